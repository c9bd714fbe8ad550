// Errors: each says what is wrong, where, and the remedy, in one line.
#pragma once

#include <stdexcept>
#include <string>

namespace skinfield {

/// Base of all errors thrown by the library. what() is "WHERE: WHAT (REMEDY)" on one line;
/// empty parts are left out.
class Error : public std::runtime_error {
 public:
  Error(const std::string& what, const std::string& where, const std::string& remedy);
  const std::string& message() const { return message_; }
  const std::string& where() const { return where_; }
  const std::string& remedy() const { return remedy_; }

 private:
  std::string message_, where_, remedy_;
};

/// An input cannot be read or is invalid (exit code 3).
class InputError : public Error {
 public:
  explicit InputError(const std::string& what, const std::string& where = {},
                      const std::string& remedy = {})
      : Error(what, where, remedy) {}
};

/// No domain can be built for this input (exit code 4).
class DomainError : public Error {
 public:
  explicit DomainError(const std::string& what, const std::string& where = {},
                       const std::string& remedy = {})
      : Error(what, where, remedy) {}
};

/// The numerical problem cannot be solved (exit code 4).
class SolveError : public Error {
 public:
  explicit SolveError(const std::string& what, const std::string& where = {},
                      const std::string& remedy = {})
      : Error(what, where, remedy) {}
};

/// An output cannot be written (exit code 5).
class IoError : public Error {
 public:
  explicit IoError(const std::string& what, const std::string& where = {},
                   const std::string& remedy = {})
      : Error(what, where, remedy) {}
};

/// The caller's `Progress::cancelled` said yes (exit code 130).
class Cancelled : public Error {
 public:
  Cancelled() : Error("interrupted", {}, {}) {}
};

}  // namespace skinfield
