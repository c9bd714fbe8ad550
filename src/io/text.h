// Reading numbers and lines from text without trusting it.
#pragma once

#include "skinfield/base/error.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skinfield::text {

/// A whole token as a number; nothing where it is none. Accepts a leading '+', "nan" and "inf"
/// (callers that need finite values test for them); out of range becomes 0 or infinity.
std::optional<double> to_number(std::string_view token);
std::optional<std::int64_t> to_integer(std::string_view token);

/// For messages: in quotes, at most 40 characters, unprintable ones as '?'.
std::string quoted(std::string_view token);
std::string lower(std::string_view s);
std::string_view trimmed(std::string_view s);

/// 1-based number of the line that holds `position`.
std::size_t line_number(std::string_view bytes, const char* position);

/// Takes blank-separated tokens off the front of a line or a whole text.
class Tokens {
 public:
  /// `where` names the file; `comment` (0: none) hides the rest of its line.
  Tokens(std::string_view bytes, std::string where, char comment = '\0')
      : whole_(bytes), rest_(bytes), where_(std::move(where)), comment_(comment) {}

  /// The next token, empty at the end.
  std::string_view next();
  std::string_view peek();
  bool done() { return peek().empty(); }
  /// What follows, to the end of the line; moves past it.
  std::string_view rest_of_line();
  std::size_t remaining() const { return rest_.size(); }
  const char* position() const { return rest_.data(); }

  double number(const char* thing);
  /// A number that is neither NaN nor infinite.
  double finite(const char* thing);
  std::int64_t integer(const char* thing);
  /// A count of things of which each takes at least `bytes_each` bytes of what is left: a claim
  /// that cannot be true fails before anything is allocated.
  std::int64_t count(const char* thing, std::size_t bytes_each);

  [[noreturn]] void fail(const std::string& what, const std::string& remedy = {}) const;

 private:
  void skip_blanks();
  std::string_view whole_, rest_;
  std::string where_;
  char comment_;
};

/// Lines with their numbers; "\r\n" and "\n"; the text need not end with one.
class Lines {
 public:
  Lines(std::string_view bytes, std::string where) : rest_(bytes), where_(std::move(where)) {}
  /// False at the end.
  bool next(std::string_view& line);
  /// The next line that holds more than blanks and a `comment`, without them.
  bool next_content(std::string_view& line, char comment);
  std::size_t number() const { return number_; }
  std::size_t remaining() const { return rest_.size(); }
  std::string where() const;
  [[noreturn]] void fail(const std::string& what, const std::string& remedy = {}) const;

 private:
  std::string_view rest_;
  std::string where_;
  std::size_t number_ = 0;
};

/// Splits at blanks.
void split(std::string_view line, std::vector<std::string_view>& fields);
/// Splits at a separator; fields keep their blanks.
void split(std::string_view line, char separator, std::vector<std::string_view>& fields);

}  // namespace skinfield::text
