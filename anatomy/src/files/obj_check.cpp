#include "files/obj_check.hpp"
#include "common/error.hpp"
#include <array>
#include <charconv>
#include <fstream>
#include <sstream>

namespace anatomy {
namespace {

// One kind of index of a face's corner. A corner names, in this order, a point, a texture coordinate and a normal.
struct Kind {
  const char *keyword, *name;
  long long count = 0, largest = 0; ///< records of this kind read so far; largest index that a face names
  std::size_t line = 0;             ///< line of the face with the largest index
};
using Kinds = std::array<Kind, 3>;

[[noreturn]] void refuse(const std::string& path, std::size_t line, const Kind& kind, long long index) {
  throw common::InputError("a face names a " + std::string(kind.name) + " that the file does not have",
                           path + ", line " + std::to_string(line),
                           "number " + std::to_string(index) + "; the file has " + std::to_string(kind.count),
                           "export the surface again, or as STL");
}

// Checks one corner of a face, for example 3/1/2. Text that is no number is left to VTK's reader.
void check_corner(const std::string& corner, Kinds& kinds, const std::string& path, std::size_t line) {
  const char *at = corner.data(), *const end = at + corner.size();
  for (Kind& kind : kinds) {
    long long index = 0;
    const auto [after, error] = std::from_chars(at, end, index);
    if (error == std::errc{}) {
      if (index == 0 || index < -kind.count)
        refuse(path, line, kind, index);
      if (index > kind.largest) {
        kind.largest = index;
        kind.line = line;
      }
    }
    at = after;
    if (at == end || *at != '/')
      return;
    ++at;
  }
}

} // namespace

void check_obj(const std::string& path) {
  Kinds kinds{{{"v", "point"}, {"vt", "texture coordinate"}, {"vn", "normal"}}};
  std::ifstream file(path);
  std::string text, word;
  for (std::size_t line = 1; std::getline(file, text); ++line) {
    std::istringstream words(text);
    words >> word;
    for (Kind& kind : kinds)
      kind.count += word == kind.keyword;
    if (word == "f")
      while (words >> word)
        check_corner(word, kinds, path, line);
    word.clear();
  }
  for (const Kind& kind : kinds)
    if (kind.largest > kind.count)
      refuse(path, kind.line, kind, kind.largest);
}

} // namespace anatomy
