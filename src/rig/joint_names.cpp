#include "skinfield/rig/handles.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

namespace skinfield {
namespace {

bool upper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
bool lower(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }

/// The words of a name in lower case: `IKBackLeg.L_end` -> ik, back, leg, l, end.
std::vector<std::string> words(const std::string& name) {
  std::vector<std::string> result;
  for (std::size_t i = 0; i < name.size();) {
    std::size_t end = i;
    while (end < name.size() && upper(name[end])) ++end;
    if (end < name.size() && lower(name[end])) {
      if (end - i > 1) {
        --end;  // the last capital begins the next word
      } else {
        while (end < name.size() && lower(name[end])) ++end;
      }
    }
    if (end == i) {
      ++i;
      continue;
    }
    std::string word = name.substr(i, end - i);
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    result.push_back(std::move(word));
    i = end;
  }
  return result;
}

bool ends_with(const std::string& word, const std::string& end) {
  return word.size() >= end.size() && word.compare(word.size() - end.size(), end.size(), end) == 0;
}

bool contains(const std::string& word, const std::string& part) {
  return word.find(part) != std::string::npos;
}

}  // namespace

bool is_helper_name(const std::string& name) {
  const std::vector<std::string> all = words(name);
  if (!all.empty() && all.back() == "end") return true;
  return std::any_of(all.begin(), all.end(), [](const std::string& word) {
    // Short words must stand alone (spike, flagpole); long ones are often glued to others
    // (handslot, poletarget).
    return word == "ik" || word == "pole" || word == "ctrl" || ends_with(word, "nub") ||
           contains(word, "control") || contains(word, "target") || contains(word, "socket") ||
           ends_with(word, "slot");
  });
}

bool is_tip_name(const std::string& name) {
  const std::vector<std::string> all = words(name);
  return std::any_of(all.begin(), all.end(), [](const std::string& word) {
    return word == "end" || word == "tip" || ends_with(word, "nub");
  });
}

}  // namespace skinfield
