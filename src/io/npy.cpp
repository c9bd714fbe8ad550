#include "skinfield/io/npy.h"

#include "io/bytes.h"
#include "io/text.h"
#include "io/zip.h"

#include <cmath>

namespace skinfield {
namespace {

constexpr std::string_view kMagic("\x93NUMPY", 6);

/// The text of `'key': value` up to the value's end.
std::string_view value_of(std::string_view header, std::string_view key, const ByteReader& reader) {
  std::size_t at = header.find(key);
  if (at == std::string_view::npos) reader.fail("the header lacks " + text::quoted(key));
  at = header.find(':', at + key.size());
  if (at == std::string_view::npos) reader.fail("the header is damaged");
  return text::trimmed(header.substr(at + 1));
}

/// Bytes of an element, 0 where the type is not supported.
std::size_t item_size(std::string_view type) {
  if (type.size() < 3 || std::string_view("<>|=").find(type[0]) == std::string_view::npos) return 0;
  const auto width = text::to_integer(type.substr(2));
  if (!width || *width < 0) return 0;
  const std::int64_t w = *width;
  switch (type[1]) {
    case 'f':
      return w == 4 || w == 8 ? static_cast<std::size_t>(w) : 0;
    case 'i':
    case 'u':
      return w == 1 || w == 2 || w == 4 || w == 8 ? static_cast<std::size_t>(w) : 0;
    case 'b':
      return w == 1 ? 1 : 0;
    case 'U':
      return w <= 1 << 20 ? static_cast<std::size_t>(4 * w) : 0;
    case 'S':
      return w <= 1 << 22 ? static_cast<std::size_t>(w) : 0;
    default:
      return 0;
  }
}

std::vector<std::int64_t> parse_shape(std::string_view value, const ByteReader& reader) {
  const std::size_t close = value.find(')');
  if (value.empty() || value.front() != '(' || close == std::string_view::npos) {
    reader.fail("the shape is damaged");
  }
  std::vector<std::string_view> fields;
  text::split(value.substr(1, close - 1), ',', fields);
  std::vector<std::int64_t> shape;
  for (const std::string_view field : fields) {
    if (text::trimmed(field).empty()) continue;
    const auto n = text::to_integer(text::trimmed(field));
    if (!n || *n < 0 || *n > INT32_MAX) reader.fail("the shape is impossible");
    shape.push_back(*n);
  }
  if (shape.size() > 32) reader.fail("the shape has too many dimensions");
  return shape;
}

void append_utf8(std::string& out, std::uint32_t c) {
  const auto byte = [&out](std::uint32_t b) { out.push_back(static_cast<char>(b)); };
  if (c > 0x10FFFF || (c >= 0xD800 && c < 0xE000)) c = 0xFFFD;
  if (c < 0x80) {
    byte(c);
  } else if (c < 0x800) {
    byte(0xC0 | c >> 6);
    byte(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    byte(0xE0 | c >> 12);
    byte(0x80 | (c >> 6 & 0x3F));
    byte(0x80 | (c & 0x3F));
  } else {
    byte(0xF0 | c >> 18);
    byte(0x80 | (c >> 12 & 0x3F));
    byte(0x80 | (c >> 6 & 0x3F));
    byte(0x80 | (c & 0x3F));
  }
}

/// Code points; a byte that is no UTF-8 becomes the replacement character.
std::vector<std::uint32_t> decode_utf8(std::string_view s) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < s.size();) {
    const auto lead = static_cast<unsigned char>(s[i++]);
    const int more = lead < 0x80 ? 0 : lead >= 0xF0 ? 3 : lead >= 0xE0 ? 2 : lead >= 0xC0 ? 1 : -1;
    if (more <= 0) {
      out.push_back(more == 0 ? lead : 0xFFFDu);
      continue;
    }
    std::uint32_t c = lead & (0x3Fu >> more);
    int taken = 0;
    while (taken < more && i < s.size() && (static_cast<unsigned char>(s[i]) & 0xC0) == 0x80) {
      c = c << 6 | (static_cast<unsigned char>(s[i++]) & 0x3Fu);
      ++taken;
    }
    out.push_back(taken == more ? c : 0xFFFDu);
  }
  return out;
}

class Elements {
 public:
  Elements(const NpyArray& array, const std::string& name)
      : type_(array.type), name_(name), reader_(array.data, name, array.type[0] == '>') {}

  double next() {
    constexpr const char* what = "the array";
    const char kind = type_[1], width = type_[2];
    if (kind == 'f') {
      return width == '4' ? static_cast<double>(reader_.get<float>(what))
                          : reader_.get<double>(what);
    }
    if (kind == 'b') return reader_.get<std::uint8_t>(what) != 0 ? 1 : 0;
    const bool is_signed = kind == 'i';
    if (!is_signed && kind != 'u') {
      throw InputError("holds " + text::quoted(type_) + ", not numbers", name_, "save float64");
    }
    switch (width) {
      case '1':
        return is_signed ? reader_.get<std::int8_t>(what) : reader_.get<std::uint8_t>(what);
      case '2':
        return is_signed ? reader_.get<std::int16_t>(what) : reader_.get<std::uint16_t>(what);
      case '4':
        return is_signed ? static_cast<double>(reader_.get<std::int32_t>(what))
                         : static_cast<double>(reader_.get<std::uint32_t>(what));
      default:
        return is_signed ? static_cast<double>(reader_.get<std::int64_t>(what))
                         : static_cast<double>(reader_.get<std::uint64_t>(what));
    }
  }

 private:
  std::string type_, name_;
  ByteReader reader_;
};

}  // namespace

std::int64_t NpyArray::size() const {
  std::int64_t n = 1;
  for (const std::int64_t d : shape) {
    if (d == 0) return 0;
  }
  for (const std::int64_t d : shape) n *= d;
  return n;
}

NpyArray parse_npy(std::string_view bytes, const std::string& name) {
  ByteReader reader(bytes, name);
  if (bytes.substr(0, 6) != kMagic) reader.fail("is no .npy array", "save it with numpy.save");
  reader.take(6, "the header");
  const auto version = reader.get<std::uint8_t>("the header");
  reader.take(1, "the header");
  if (version < 1 || version > 3) reader.fail("an unknown .npy version", "save it with numpy.save");
  const std::uint32_t length = version == 1 ? reader.get<std::uint16_t>("the header")
                                            : reader.get<std::uint32_t>("the header");
  const std::string_view header = reader.take(length, "the header");

  NpyArray array;
  const std::string_view type = value_of(header, "'descr'", reader);
  const std::size_t close = type.find('\'', 1);
  if (type.empty() || type.front() != '\'' || close == std::string_view::npos) {
    reader.fail("the array is not of a plain type", "save float64");
  }
  array.type = std::string(type.substr(1, close - 1));
  const std::size_t each = item_size(array.type);
  if (each == 0 && array.type != "<U0" && array.type != "|S0") {
    reader.fail("arrays of type " + text::quoted(array.type) + " are not read", "save float64");
  }
  array.fortran = value_of(header, "'fortran_order'", reader).starts_with("True");
  array.shape = parse_shape(value_of(header, "'shape'", reader), reader);
  std::uint64_t elements = 1;
  for (const std::int64_t n : array.shape) {
    if (n == 0) elements = 0;
  }
  for (const std::int64_t n : array.shape) {
    if (elements == 0) break;
    const std::uint64_t limit = each ? reader.remaining() / each : 1u << 20;
    if (static_cast<std::uint64_t>(n) > limit / elements) {
      reader.fail("the shape claims more than the file holds", "it is truncated or damaged");
    }
    elements *= static_cast<std::uint64_t>(n);
  }
  array.data = std::string(reader.take(elements * each, "the array"));
  return array;
}

std::string format_npy(const NpyArray& array) {
  std::string header = "{'descr': '" + array.type +
                       "', 'fortran_order': " + (array.fortran ? "True" : "False") + ", 'shape': (";
  for (const std::int64_t n : array.shape) header.append(std::to_string(n)).append(",");
  if (array.shape.size() > 1) header.pop_back();
  header += "), }";
  // Padded with blanks and a newline so that the data begins at a multiple of 64.
  header.append(63 - (kMagic.size() + 4 + header.size()) % 64, ' ').push_back('\n');
  std::string out(kMagic);
  out.append("\1\0", 2);
  put_little(out, static_cast<std::uint16_t>(header.size()));
  return out + header + array.data;
}

RowMatrix npy_matrix(const NpyArray& array, const std::string& name) {
  if (array.shape.size() > 2) {
    throw InputError("has more than two dimensions", name, "save a vector or a matrix");
  }
  const std::int64_t rows = array.shape.empty() ? 1 : array.shape[0];
  const std::int64_t columns = array.shape.size() < 2 ? 1 : array.shape[1];
  RowMatrix out(rows, columns);
  Elements elements(array, name);
  for (std::int64_t k = 0; k < rows * columns; ++k) {
    if (array.fortran) {
      out(k % rows, k / rows) = elements.next();
    } else {
      out.data()[k] = elements.next();
    }
  }
  return out;
}

std::vector<std::int64_t> npy_integers(const NpyArray& array, const std::string& name) {
  const RowMatrix values = npy_matrix(array, name);
  std::vector<std::int64_t> out;
  out.reserve(static_cast<std::size_t>(values.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double v = values.data()[i];
    if (!(std::abs(v) < 9e15) || v != std::floor(v)) {
      throw InputError("holds a number that is no integer", name, "save integers");
    }
    out.push_back(static_cast<std::int64_t>(v));
  }
  return out;
}

std::vector<std::string> npy_strings(const NpyArray& array, const std::string& name) {
  if (array.type.size() < 3 || array.type[1] != 'U') {
    throw InputError("names are not unicode strings", name, "save them as a numpy str array");
  }
  ByteReader reader(array.data, name, array.type[0] == '>');
  const std::int64_t n = array.size();
  const std::int64_t width = text::to_integer(std::string_view(array.type).substr(2)).value_or(0);
  std::vector<std::string> out(static_cast<std::size_t>(n));
  for (std::string& s : out) {
    for (std::int64_t i = 0; i < width; ++i) {
      const auto c = reader.get<std::uint32_t>("a name");
      if (c != 0) append_utf8(s, c);
    }
  }
  return out;
}

NpyArray npy_from_matrix(const RowMatrix& W) {
  NpyArray array{"<f8", false, {W.rows(), W.cols()}, {}};
  array.data.reserve(static_cast<std::size_t>(W.size()) * 8);
  for (Eigen::Index i = 0; i < W.size(); ++i) put_little(array.data, W.data()[i]);
  return array;
}

NpyArray npy_from_vector(const std::vector<double>& values) {
  NpyArray array{"<f8", false, {static_cast<std::int64_t>(values.size())}, {}};
  for (const double v : values) put_little(array.data, v);
  return array;
}

NpyArray npy_from_integers(const std::vector<std::int64_t>& values) {
  NpyArray array{"<i8", false, {static_cast<std::int64_t>(values.size())}, {}};
  for (const std::int64_t v : values) put_little(array.data, v);
  return array;
}

NpyArray npy_from_strings(const std::vector<std::string>& utf8) {
  std::vector<std::vector<std::uint32_t>> decoded;
  std::size_t width = 1;
  for (const std::string& s : utf8) {
    decoded.push_back(decode_utf8(s));
    width = std::max(width, decoded.back().size());
  }
  NpyArray array{"<U" + std::to_string(width), false, {static_cast<std::int64_t>(utf8.size())}, {}};
  for (auto& s : decoded) {
    s.resize(width, 0);
    for (const std::uint32_t c : s) put_little(array.data, c);
  }
  return array;
}

NpzArrays parse_npz(std::string_view bytes, const std::string& name) {
  NpzArrays arrays;
  for (const ZipEntry& entry : read_zip(bytes, name)) {
    std::string key = entry.name;
    if (key.ends_with(".npy")) key.resize(key.size() - 4);
    arrays.emplace_back(key, parse_npy(entry.bytes, name + ": " + key));
  }
  return arrays;
}

std::string format_npz(const NpzArrays& arrays) {
  std::vector<ZipEntry> entries;
  for (const auto& [name, array] : arrays) entries.push_back({name + ".npy", format_npy(array)});
  return write_zip(entries);
}

const NpyArray* find_array(const NpzArrays& arrays, std::string_view name) {
  for (const auto& [key, array] : arrays) {
    if (key == name) return &array;
  }
  return nullptr;
}

}  // namespace skinfield
