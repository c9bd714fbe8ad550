#include "io/text.h"
#include "skinfield/io/matrix_file.h"

#include <fmt/format.h>

namespace skinfield {
namespace {

struct Field {
  std::string text;
  bool quoted = false;
};

char separator_of(std::string_view line) {
  for (const char c : {',', ';', '\t'}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

/// One line; quotes may hold separators, and "" is a quote.
void parse_line(std::string_view line, char separator, std::vector<Field>& fields) {
  fields.clear();
  if (separator == ' ') {
    std::vector<std::string_view> words;
    text::split(line, words);
    for (const std::string_view word : words) fields.push_back({std::string(word), false});
    return;
  }
  for (std::size_t i = 0; i <= line.size(); ++i) {
    Field field;
    while (i < line.size() && line[i] == ' ') ++i;
    if (i < line.size() && line[i] == '"') {
      field.quoted = true;
      for (++i; i < line.size(); ++i) {
        if (line[i] == '"') {
          if (i + 1 >= line.size() || line[i + 1] != '"') break;
          ++i;
        }
        field.text.push_back(line[i]);
      }
      i = std::min(line.find(separator, std::min(i, line.size())), line.size());
    } else {
      const std::size_t end = std::min(line.find(separator, i), line.size());
      field.text = std::string(text::trimmed(line.substr(i, end - i)));
      i = end;
    }
    fields.push_back(std::move(field));
  }
}

bool is_header(const std::vector<Field>& fields) {
  for (const Field& field : fields) {
    if (field.quoted || !text::to_number(field.text)) return true;
  }
  return false;
}

}  // namespace

CsvTable parse_csv(std::string_view bytes, const std::string& name) {
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3);
  text::Lines lines(bytes, name);
  CsvTable table;
  std::string_view line;
  std::vector<Field> fields;
  std::vector<double> values;
  std::size_t columns = 0;
  char separator = ',';
  while (lines.next_content(line, '#')) {
    const bool first = columns == 0;
    if (first) separator = separator_of(line);
    parse_line(line, separator, fields);
    if (first) columns = fields.size();
    if (fields.size() != columns) {
      lines.fail("has " + std::to_string(fields.size()) + " fields, not " +
                     std::to_string(columns) + " like the first line",
                 "make all lines equally long");
    }
    if (first && is_header(fields)) {
      for (Field& field : fields) table.header.push_back(std::move(field.text));
      continue;
    }
    for (const Field& field : fields) {
      const auto value = text::to_number(field.text);
      if (!value) lines.fail(text::quoted(field.text) + " is not a number");
      values.push_back(*value);
    }
  }
  if (values.empty()) throw InputError("holds no numbers", name, "name another file");
  table.values =
      Eigen::Map<const RowMatrix>(values.data(), static_cast<Eigen::Index>(values.size() / columns),
                                  static_cast<Eigen::Index>(columns));
  return table;
}

std::string format_csv(const CsvTable& table) {
  fmt::memory_buffer out;
  for (std::size_t j = 0; j < table.header.size(); ++j) {
    if (j > 0) out.push_back(',');
    out.push_back('"');
    for (const char c : table.header[j]) {
      // A line is a row and '#' begins a comment, so that names cannot hold either.
      out.push_back(c == '\n' || c == '\r' || c == '#' ? ' ' : c);
      if (c == '"') out.push_back('"');
    }
    out.push_back('"');
  }
  if (!table.header.empty()) out.push_back('\n');
  for (Eigen::Index i = 0; i < table.values.rows(); ++i) {
    for (Eigen::Index j = 0; j < table.values.cols(); ++j) {
      if (j > 0) out.push_back(',');
      fmt::format_to(std::back_inserter(out), "{:.17g}", table.values(i, j));
    }
    out.push_back('\n');
  }
  return fmt::to_string(out);
}

}  // namespace skinfield
