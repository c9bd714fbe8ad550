#include "skinfield/io/sfield.h"
#include "fuzz.h"
#include "io/zip.h"

#include <string>
#include <vector>

// The archive itself; and, since checksums stop nearly all changes to it, an intact one whose
// entries are cut from the bytes: a line with a name, then what follows up to the next such line.
static void read(std::string_view bytes) {
  if (bytes.empty() || bytes[0] == 'P') {
    skinfield::parse_sfield(bytes, "fuzz");
    return;
  }
  constexpr std::string_view kMark = "\n=== ";
  std::vector<skinfield::ZipEntry> entries;
  std::size_t at = bytes.find(kMark);
  while (at != std::string_view::npos) {
    const std::size_t name = at + kMark.size();
    const std::size_t line = bytes.find('\n', name);
    if (line == std::string_view::npos) break;
    at = bytes.find(kMark, line);
    entries.push_back(
        {std::string(bytes.substr(name, line - name)),
         std::string(bytes.substr(
             line + 1, at == std::string_view::npos ? std::string_view::npos : at - line - 1))});
  }
  skinfield::parse_sfield(skinfield::write_zip(entries), "fuzz");
}
SKINFIELD_FUZZ(read)
