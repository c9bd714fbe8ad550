#include "io/zip.h"

#include "io/bytes.h"

#include <zlib.h>
#include <limits>

namespace skinfield {
namespace {

constexpr std::uint32_t kLocal = 0x04034b50, kCentral = 0x02014b50, kEnd = 0x06054b50;
constexpr std::size_t kEndBytes = 22, kCentralBytes = 46;
constexpr std::uint64_t kLargest = std::numeric_limits<std::int32_t>::max();
// Deflate cannot do better than 1032:1, so that a larger claim is a lie.
constexpr std::uint64_t kBestRatio = 1032;
constexpr std::uint16_t kFirstOfJanuary1980 = 0x21;

std::uint32_t checksum(std::string_view bytes) {
  const uLong start = crc32(0, nullptr, 0);
  return static_cast<std::uint32_t>(
      crc32_z(start, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string inflate_entry(std::string_view packed, std::uint32_t size, const ByteReader& reader) {
  if (size > packed.size() * kBestRatio + 64) {
    reader.fail("an entry claims an impossible size", "the file is damaged");
  }
  std::string out(size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) reader.fail("zlib does not start");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  char none = 0;
  stream.next_out = reinterpret_cast<Bytef*>(size ? out.data() : &none);
  stream.avail_out = size;
  const int status = inflate(&stream, Z_FINISH);
  const bool complete = status == Z_STREAM_END && stream.avail_out == 0;
  inflateEnd(&stream);
  if (!complete) reader.fail("an entry's compressed data is damaged", "write the file again");
  return out;
}

std::string deflate_entry(std::string_view bytes) {
  z_stream stream{};
  if (deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw IoError("zlib does not start", {}, "check the memory");
  }
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// Version, flags, method, time and date, which local and central headers share.
void put_common(std::string& out) {
  put_little<std::uint16_t>(out, 20);
  put_little<std::uint16_t>(out, 0);
  put_little<std::uint16_t>(out, 8);
  put_little<std::uint16_t>(out, 0);
  put_little<std::uint16_t>(out, kFirstOfJanuary1980);
}

}  // namespace

std::vector<ZipEntry> read_zip(std::string_view bytes, const std::string& name) {
  ByteReader whole(bytes, name);
  if (bytes.size() > kLargest) whole.fail("archives above 2 GB are not read", "save it as .npy");
  const std::string mark = "PK\5\6";
  const std::size_t end = bytes.rfind(mark);
  if (end == std::string_view::npos || bytes.size() - end < kEndBytes) {
    whole.fail("is no complete NPZ archive", "it is truncated or damaged");
  }
  ByteReader tail(bytes.substr(end), name);
  if (tail.get<std::uint32_t>("the end") != kEnd) tail.fail("is damaged");
  tail.take(6, "the end");
  const auto count = tail.get<std::uint16_t>("the end");
  tail.take(4, "the end");
  const auto directory = tail.get<std::uint32_t>("the end");
  if (directory > end) whole.fail("the archive's directory is misplaced", "the file is damaged");

  ByteReader central(bytes.substr(directory), name);
  std::vector<ZipEntry> entries;
  std::uint64_t total = 0;
  central.expect(count, kCentralBytes, "entries");
  for (std::uint16_t i = 0; i < count; ++i) {
    if (central.get<std::uint32_t>("the directory") != kCentral) {
      central.fail("the archive's directory is damaged", "write the file again");
    }
    central.take(4, "the directory");
    const auto flags = central.get<std::uint16_t>("the directory");
    const auto method = central.get<std::uint16_t>("the directory");
    central.take(4, "the directory");
    const auto crc = central.get<std::uint32_t>("the directory");
    const auto packed = central.get<std::uint32_t>("the directory");
    const auto size = central.get<std::uint32_t>("the directory");
    const auto name_size = central.get<std::uint16_t>("the directory");
    const auto extra_size = central.get<std::uint16_t>("the directory");
    const auto comment_size = central.get<std::uint16_t>("the directory");
    central.take(8, "the directory");
    const auto offset = central.get<std::uint32_t>("the directory");
    ZipEntry entry;
    entry.name = std::string(central.take(name_size, "an entry's name"));
    central.take(std::uint64_t{extra_size} + comment_size, "the directory");
    total += size;
    // Entries that share their data could claim it many times over.
    if (size > kLargest || total > bytes.size() * kBestRatio + 65536 || offset > bytes.size()) {
      central.fail("an entry claims an impossible size or place", "the file is damaged");
    }
    if ((flags & 1) != 0 || (method != 0 && method != 8)) {
      central.fail("an entry is encrypted or packed by an unknown method", "save it with numpy");
    }
    ByteReader local(bytes.substr(offset), name);
    if (local.get<std::uint32_t>("an entry") != kLocal) local.fail("an entry is misplaced");
    local.take(22, "an entry");
    const auto local_name = local.get<std::uint16_t>("an entry");
    const auto local_extra = local.get<std::uint16_t>("an entry");
    local.take(std::uint64_t{local_name} + local_extra, "an entry");
    const std::string_view data = local.take(packed, "an entry's data");
    if (method == 0 && packed != size) local.fail("a stored entry's sizes differ");
    entry.bytes = method == 0 ? std::string(data) : inflate_entry(data, size, local);
    if (checksum(entry.bytes) != crc) {
      local.fail("an entry's checksum is wrong", "the file is damaged; write it again");
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

std::string write_zip(const std::vector<ZipEntry>& entries) {
  std::string out, directory;
  for (const ZipEntry& entry : entries) {
    if (entry.bytes.size() > kLargest || out.size() > kLargest) {
      throw IoError("the array is too large for .npz", entry.name, "write .npy");
    }
    const std::string packed = deflate_entry(entry.bytes);
    std::string sizes;
    put_little<std::uint32_t>(sizes, checksum(entry.bytes));
    put_little<std::uint32_t>(sizes, static_cast<std::uint32_t>(packed.size()));
    put_little<std::uint32_t>(sizes, static_cast<std::uint32_t>(entry.bytes.size()));
    put_little<std::uint16_t>(sizes, static_cast<std::uint16_t>(entry.name.size()));
    put_little<std::uint16_t>(sizes, 0);

    put_little(directory, kCentral);
    put_little<std::uint16_t>(directory, 20);
    put_common(directory);
    directory += sizes;
    directory.append(10, '\0');
    put_little(directory, static_cast<std::uint32_t>(out.size()));
    directory += entry.name;

    put_little(out, kLocal);
    put_common(out);
    out += sizes;
    out += entry.name;
    out += packed;
  }
  const auto start = static_cast<std::uint32_t>(out.size());
  out += directory;
  put_little(out, kEnd);
  put_little<std::uint32_t>(out, 0);
  put_little<std::uint16_t>(out, static_cast<std::uint16_t>(entries.size()));
  put_little<std::uint16_t>(out, static_cast<std::uint16_t>(entries.size()));
  put_little<std::uint32_t>(out, static_cast<std::uint32_t>(directory.size()));
  put_little<std::uint32_t>(out, start);
  put_little<std::uint16_t>(out, 0);
  return out;
}

}  // namespace skinfield
