#include "files/ply_check.hpp"
#include "common/error.hpp"
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

namespace anatomy {
namespace {

using common::InputError;

constexpr std::size_t longest_line = 4000; // characters: VTK reads lines into 4096 bytes
// Largest number of corners of a polygon or numbers of a list: VTK counts them in one byte.
constexpr double most_corners = 255;
// Largest number of records of an element: VTK counts them in an int.
constexpr std::uintmax_t most_records = 2'000'000'000;

const std::map<std::string, std::size_t> bytes_of{{"char", 1},  {"uchar", 1},  {"short", 2},   {"ushort", 2},
                                                  {"int", 4},   {"uint", 4},   {"float", 4},   {"double", 8},
                                                  {"int8", 1},  {"uint8", 1},  {"int16", 2},   {"uint16", 2},
                                                  {"int32", 4}, {"uint32", 4}, {"float32", 4}, {"float64", 8}};

struct Property {
  std::string name, type, count_type; ///< count_type: type of a list's length; empty if the property is no list
};

struct Element {
  std::string name;
  std::uintmax_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  std::string format; ///< as the file names it: see coding_of()
  std::vector<Element> elements;
  std::streamoff body = 0;
};

[[noreturn]] void refuse(const std::string& path, const std::string& where, const std::string& value) {
  throw InputError("not a sound PLY file", path + ", " + where, value, "export the surface again, as PLY or as STL");
}

[[noreturn]] void refuse_long_list(const std::string& path, const std::string& where, double items) {
  throw InputError("a polygon or list of the PLY file is too long", path + ", " + where,
                   std::to_string(static_cast<long long>(items)) + " numbers in one list, 255 at most",
                   "triangulate the polygons before the export (caps are often one polygon), or export as STL");
}

bool is_float(const std::string& type) {
  return type[0] == 'f' || type[0] == 'd';
}

Element element_of(const std::vector<std::string>& words, const std::string& path, const std::string& line) {
  Element element;
  const bool three = words.size() == 3;
  if (three)
    element.name = words[1];
  const char* end = three ? words[2].data() + words[2].size() : nullptr;
  if (!three || std::from_chars(words[2].data(), end, element.count).ptr != end || element.count > most_records)
    refuse(path, "header", line);
  return element;
}

Property property_of(const std::vector<std::string>& words, const std::string& path, const std::string& line) {
  const bool list = words.size() == 5 && words[1] == "list";
  if (!list && words.size() != 3)
    refuse(path, "header", line);
  Property property{words.back(), words[words.size() - 2], list ? words[2] : ""};
  if (!bytes_of.contains(property.type) || (list && (!bytes_of.contains(words[2]) || is_float(words[2]))))
    refuse(path, "header", line);
  return property;
}

Header header_of(std::ifstream& file, const std::string& path) {
  Header header;
  std::string line;
  for (int n = 0; std::getline(file, line) && line.size() < longest_line; ++n) {
    if (n == 0 && line != "ply")
      refuse(path, "line 1", "no \"ply\" followed by a line feed");
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;)
      words.push_back(word);
    if (std::any_of(line.begin(), line.end(), [](unsigned char c) { return c < 32 && c != '\t'; }))
      refuse(path, "header, line " + std::to_string(n + 1), "a carriage return or another control character");
    if (words.empty() || n == 0 || words[0] == "comment" || words[0] == "obj_info")
      continue;
    if (words[0] == "end_header" && words.size() == 1) {
      header.body = file.tellg();
      return header;
    }
    if (words[0] == "format" && words.size() == 3 && words[2] == "1.0")
      header.format = words[1];
    else if (words[0] == "element")
      header.elements.push_back(element_of(words, path, line));
    else if (words[0] == "property" && !header.elements.empty())
      header.elements.back().properties.push_back(property_of(words, path, line));
    else
      refuse(path, "header, line " + std::to_string(n + 1), line.substr(0, 80));
  }
  refuse(path, "header", line.size() < longest_line ? "no end_header" : "a line of more than 4000 characters");
}

bool has(const Element& element, const std::string& name, bool list) {
  return std::count_if(element.properties.begin(), element.properties.end(),
                       [&](const Property& p) { return p.name == name && p.count_type.empty() != list; }) == 1;
}

bool names_vertices(const Property& property) {
  return !property.count_type.empty() && (property.name == "vertex_indices" || property.name == "vertex_index");
}

// How the body's numbers are written.
enum class Coding { text, little_endian, big_endian };

Coding coding_of(const Header& header, const std::string& path) {
  if (header.format == "ascii")
    return Coding::text;
  if (header.format == "binary_little_endian")
    return Coding::little_endian;
  if (header.format == "binary_big_endian")
    return Coding::big_endian;
  refuse(path, "header, format", header.format.empty() ? "missing" : header.format);
}

void check_elements(const Header& header, const std::string& path) {
  const auto& elements = header.elements;
  if (elements.size() < 2 || elements[0].name != "vertex" || elements[1].name != "face")
    refuse(path, "header, elements", "not vertex and face in this order");
  for (std::size_t i = 2; i < elements.size(); ++i)
    if (elements[i].name == "vertex" || elements[i].name == "face")
      refuse(path, "header, elements", "a second " + elements[i].name);
  for (const Property& p : elements[0].properties)
    if (!p.count_type.empty() || !has(elements[0], p.name, false))
      refuse(path, "header, vertex", p.name + " is a list or named twice");
  for (const char* name : {"x", "y", "z"})
    if (!has(elements[0], name, false))
      refuse(path, "header, vertex", std::string("no property ") + name);
  for (const Property& p : elements[1].properties)
    if (!has(elements[1], p.name, !p.count_type.empty()))
      refuse(path, "header, face", p.name + " is named twice");
  for (const Property& p : elements[1].properties)
    if (names_vertices(p) && is_float(p.type))
      refuse(path, "header, face", p.name + " of type " + p.type);
  if (has(elements[1], "vertex_indices", true) == has(elements[1], "vertex_index", true))
    refuse(path, "header, face", "not one list named vertex_indices or vertex_index");
}

std::string record(const Element& element, std::uintmax_t i) {
  return element.name + " " + std::to_string(i);
}

// Checks the records of an element in a text body. Each has a line of its own, with at least as many numbers as its
// properties need.
void check_text(std::ifstream& file, const Element& element, const std::string& path, std::uintmax_t vertices) {
  std::string line;
  for (std::uintmax_t i = 0; i < element.count; ++i) {
    if (!std::getline(file, line) || line.size() >= longest_line)
      refuse(path, record(element, i), file ? "too long a line" : "missing");
    const char *at = line.data(), *end = at + line.size();
    const auto next = [&] {
      while (at < end && (*at == ' ' || *at == '\t'))
        ++at;
      double value = 0;
      const auto [stop, error] = std::from_chars(at + (at < end && *at == '+'), end, value);
      if (error != std::errc() || (stop < end && *stop != ' ' && *stop != '\t' && *stop != '\r'))
        refuse(path, record(element, i), line.substr(0, 80));
      at = stop;
      return value;
    };
    for (const Property& property : element.properties) {
      const double items = property.count_type.empty() ? 1 : next();
      if (items > most_corners)
        refuse_long_list(path, record(element, i), items);
      if (!(items >= 0 && items == static_cast<int>(items)))
        refuse(path, record(element, i), line.substr(0, 80));
      for (int k = 0; k < static_cast<int>(items); ++k)
        if (const double value = next();
            names_vertices(property) && !(value >= 0 && value < static_cast<double>(vertices)))
          refuse(path, record(element, i), line.substr(0, 80));
    }
  }
}

// The integer that `size` bytes hold; `big` says that the most significant byte comes first.
std::int64_t integer(const unsigned char* bytes, std::size_t size, bool is_signed, bool big) {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < size; ++k)
    value |= static_cast<std::uint64_t>(bytes[big ? size - 1 - k : k]) << (8 * k);
  if (is_signed && size < 8 && (value >> (8 * size - 1)) != 0)
    return static_cast<std::int64_t>(value) - (std::int64_t{1} << (8 * size));
  return static_cast<std::int64_t>(value);
}

// Checks the records of an element in a binary body.
void check_binary(std::ifstream& file, const Element& element, const std::string& path, std::uintmax_t vertices,
                  bool big) {
  std::vector<char> block(most_corners * 8);
  const auto take = [&](std::size_t bytes, std::uintmax_t i) {
    if (!file.read(block.data(), static_cast<std::streamsize>(bytes)))
      refuse(path, record(element, i), "missing: the file ends");
  };
  for (std::uintmax_t i = 0; i < element.count; ++i)
    for (const Property& property : element.properties) {
      std::int64_t items = 1;
      if (!property.count_type.empty()) {
        const std::size_t width = bytes_of.at(property.count_type);
        take(width, i);
        items =
            integer(reinterpret_cast<const unsigned char*>(block.data()), width, property.count_type[0] != 'u', big);
        if (items > static_cast<std::int64_t>(most_corners))
          refuse_long_list(path, record(element, i), static_cast<double>(items));
        if (items < 0)
          refuse(path, record(element, i), "a list of " + std::to_string(items));
      }
      const std::size_t size = bytes_of.at(property.type);
      take(static_cast<std::size_t>(items) * size, i);
      for (std::size_t k = 0; names_vertices(property) && k < static_cast<std::size_t>(items); ++k)
        if (const std::int64_t id = integer(reinterpret_cast<const unsigned char*>(block.data()) + k * size, size,
                                            property.type[0] != 'u', big);
            id < 0 || id >= static_cast<std::int64_t>(vertices))
          refuse(path, record(element, i), "names vertex " + std::to_string(id));
    }
}

} // namespace

void check_ply(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const Header header = header_of(file, path);
  const Coding coding = coding_of(header, path);
  check_elements(header, path);
  for (std::size_t i = 0; i < 2; ++i) // VTK reads no other elements
    if (coding == Coding::text)
      check_text(file, header.elements[i], path, header.elements[0].count);
    else
      check_binary(file, header.elements[i], path, header.elements[0].count, coding == Coding::big_endian);
}

} // namespace anatomy
