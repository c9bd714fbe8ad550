// The part of ZIP that NPZ uses: stored and deflated entries, no encryption, below 2 GB.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace skinfield {

struct ZipEntry {
  std::string name;
  std::string bytes;
};

/// All entries, their checksums verified. Throws InputError.
std::vector<ZipEntry> read_zip(std::string_view bytes, const std::string& name);

/// Deflates every entry. The same entries give the same bytes (dates are fixed). Throws IoError
/// where an entry is too large for the format.
std::string write_zip(const std::vector<ZipEntry>& entries);

}  // namespace skinfield
