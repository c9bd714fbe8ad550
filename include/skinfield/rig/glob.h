// Shell patterns for joint and handle names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace skinfield {

/// `*` any characters, `?` one character, everything else itself; the whole text must match.
bool glob_match(std::string_view pattern, std::string_view text);
bool glob_match_any(const std::vector<std::string>& patterns, std::string_view text);

}  // namespace skinfield
