#include "fuzz.h"
#include "io/zip.h"
#include "skinfield/io/weights_file.h"

// The archive itself; and, since checksums stop nearly all changes to it, CSR arrays in an intact
// one: the bytes are cut into its five entries.
static void read(std::string_view bytes) {
  if (bytes.empty() || bytes[0] == 'P') {
    skinfield::parse_weights(bytes, ".npz", "fuzz");
    return;
  }
  std::vector<skinfield::ZipEntry> entries;
  for (const char* name : {"data", "indices", "indptr", "shape", "handle_names"}) {
    const auto next = bytes.find("\x93NUMPY", 1);
    entries.push_back({std::string(name) + ".npy", std::string(bytes.substr(0, next))});
    bytes.remove_prefix(next < bytes.size() ? next : bytes.size());
  }
  if (!bytes.empty()) entries.push_back({"weights.npy", std::string(bytes)});
  skinfield::parse_weights(skinfield::write_zip(entries), ".npz", "fuzz");
}
SKINFIELD_FUZZ(read)
