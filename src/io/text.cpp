#include "io/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace skinfield::text {
namespace {

bool blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r') || c == '\0'; }

}  // namespace

std::optional<double> to_number(std::string_view token) {
  if (!token.empty() && token.front() == '+') {
    token.remove_prefix(1);
    if (!token.empty() && token.front() == '-') return std::nullopt;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (end != token.data() + token.size() || token.empty()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    return std::strtod(std::string(token).c_str(), nullptr);
  }
  if (error != std::errc()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> to_integer(std::string_view token) {
  if (token.size() > 1 && token.front() == '+' && token[1] != '-') token.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (error != std::errc() || end != token.data() + token.size()) return std::nullopt;
  return value;
}

std::string quoted(std::string_view token) {
  std::string out = "\"";
  for (const char c : token.substr(0, 40)) {
    out.push_back(static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c);
  }
  out.append(token.size() > 40 ? "...\"" : "\"");
  return out;
}

std::string lower(std::string_view s) {
  std::string out(s);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && blank(s.back())) s.remove_suffix(1);
  return s;
}

std::size_t line_number(std::string_view bytes, const char* position) {
  return 1 + static_cast<std::size_t>(std::count(bytes.data(), position, '\n'));
}

void Tokens::skip_blanks() {
  for (;;) {
    while (!rest_.empty() && blank(rest_.front())) rest_.remove_prefix(1);
    if (!comment_ || rest_.empty() || rest_.front() != comment_) return;
    rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size()));
  }
}

std::string_view Tokens::next() {
  const std::string_view token = peek();
  rest_.remove_prefix(token.size());
  return token;
}

std::string_view Tokens::peek() {
  skip_blanks();
  std::size_t end = 0;
  while (end < rest_.size() && !blank(rest_[end]) && !(comment_ && rest_[end] == comment_)) ++end;
  return rest_.substr(0, end);
}

std::string_view Tokens::rest_of_line() {
  const std::size_t end = rest_.find('\n');
  const std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  return trimmed(line);
}

double Tokens::number(const char* thing) {
  const std::string_view token = peek();
  if (token.empty()) fail(std::string("the file ends before ") + thing, "it is truncated");
  const auto value = to_number(token);
  if (!value) {
    fail(std::string(thing) + " is not a number: " + quoted(token));
  }
  rest_.remove_prefix(token.size());
  return *value;
}

double Tokens::finite(const char* thing) {
  const double value = number(thing);
  if (!std::isfinite(value)) {
    fail(std::string(thing) + " is not finite", "export the file again without it");
  }
  return value;
}

std::int64_t Tokens::integer(const char* thing) {
  const std::string_view token = peek();
  if (token.empty()) fail(std::string("the file ends before ") + thing, "it is truncated");
  const auto value = to_integer(token);
  if (!value) {
    fail(std::string(thing) + " is not an integer: " + quoted(token));
  }
  rest_.remove_prefix(token.size());
  return *value;
}

std::int64_t Tokens::count(const char* thing, std::size_t bytes_each) {
  const std::int64_t n = integer(thing);
  if (n < 0 || static_cast<std::uint64_t>(n) > (rest_.size() + 1) / bytes_each || n > INT32_MAX) {
    fail(std::string(thing) + " is " + std::to_string(n) + ", more than the file can hold",
         "it is truncated or damaged");
  }
  return n;
}

void Tokens::fail(const std::string& what, const std::string& remedy) const {
  const auto line = line_number(whole_, rest_.data());
  throw InputError(what, where_ + ":" + std::to_string(line), remedy);
}

bool Lines::next(std::string_view& line) {
  if (rest_.empty()) return false;
  ++number_;
  const std::size_t end = rest_.find('\n');
  line = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

bool Lines::next_content(std::string_view& line, char comment) {
  while (next(line)) {
    line = trimmed(line.substr(0, line.find(comment)));
    if (!line.empty()) return true;
  }
  return false;
}

std::string Lines::where() const { return where_ + ":" + std::to_string(number_); }

void Lines::fail(const std::string& what, const std::string& remedy) const {
  throw InputError(what, where(), remedy);
}

void split(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  std::size_t i = 0;
  while (i < line.size()) {
    while (i < line.size() && blank(line[i])) ++i;
    std::size_t end = i;
    while (end < line.size() && !blank(line[end])) ++end;
    if (end > i) fields.push_back(line.substr(i, end - i));
    i = end;
  }
}

void split(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  for (;;) {
    const std::size_t end = line.find(separator);
    fields.push_back(line.substr(0, end));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

}  // namespace skinfield::text
