#include "mask/mask_header.hpp"
#include "common/error.hpp"
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <sstream>
#include <vector>
#include <zlib.h>

namespace anatomy {
namespace {

using common::InputError;
using Fields = std::map<std::string, std::string>;
// Largest ratio of voxel bytes to packed bytes. Deflate's limit is 1032.
constexpr std::uintmax_t largest_packing_ratio = 1100;
constexpr std::size_t longest_key = 200; // characters; VTK's reader of MetaImage overruns its memory from 255 on

bool is_text(const std::string& line) {
  return std::none_of(line.begin(), line.end(),
                      [](unsigned char c) { return std::iscntrl(c) && c != '\t' && c != '\r'; });
}

// Checks the lines of a NRRD header up to the empty line that ends it. VTK's reader never returns if the empty line is
// missing, or if a line before it holds a control character. The format asks for a blank after a field's colon: the
// reader ignores a field without it.
void check_nrrd_lines(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (int n = 0; std::getline(file, line); ++n)
    if (line.empty() || line == "\r")
      return;
    else if (!is_text(line))
      throw InputError("the header of the mask cannot be read", path + ", line " + std::to_string(n + 1),
                       "a control character", "export the mask again");
    else if (const std::size_t next = line.find(':') + 1;
             next > 0 && next < line.size() && line[0] != '#' && !std::strchr(" =\r", line[next]))
      throw InputError("the header of the mask cannot be read", path + ", line " + std::to_string(n + 1),
                       "no blank after the colon", "write the blank, or export the mask again");
  throw InputError("the header of the mask is incomplete", path, "no empty line ends it", "export the mask again");
}

// Checks that each line of a MetaImage header has a key of at most 200 characters, followed by "=" or ":". VTK's reader
// takes a line without these signs for a part of the next line's key.
void check_meta_lines(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (int n = 1; std::getline(file, line); ++n) {
    const std::size_t at = line.find_first_of("=:"), first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos)
      continue;
    if (!is_text(line) || at == std::string::npos || at - std::min(first, at) > longest_key)
      throw InputError("the header of the mask cannot be read", path + ", line " + std::to_string(n),
                       !is_text(line)            ? "a control character"
                       : at == std::string::npos ? "no key = value"
                                                 : "a key of " + std::to_string(at - first) + " characters",
                       "export the mask again");
    if (line.compare(first, 15, "ElementDataFile") == 0)
      return;
  }
}

// The values by key of the lines "key <separator> value". Reading ends after the line with the key `last`, at the first
// empty line, or at a line with a control character.
Fields header_of(const std::string& path, char separator, const std::string& last) {
  std::ifstream file(path, std::ios::binary);
  Fields fields;
  std::string line;
  while (std::getline(file, line) && is_text(line)) {
    line.erase(std::remove(line.begin(), line.end(), '\r'), line.end());
    if (line.empty())
      break;
    const std::size_t at = line.find(separator);
    if (at == std::string::npos || line.front() == '#')
      continue;
    std::string key = line.substr(0, at);
    key.erase(key.find_last_not_of(' ') + 1);
    fields[key] = line.substr(at + 1);
    if (key == last)
      break;
  }
  return fields;
}

// Bytes up to the end of the line that begins with the key `last`.
std::streamoff length_of_header(const std::string& path, const std::string& last) {
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(last))
      break;
  return file.tellg();
}

// The value of the first of these field names that the header has; empty if it has none.
std::string field(const Fields& fields, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (const auto found = fields.find(name); found != fields.end())
      return found->second;
  return "";
}

// Reads exactly `count` numbers from a text, in which brackets and commas count as blanks; else throws InputError.
std::vector<double> numbers(std::string text, std::size_t count, const std::string& what, const std::string& path) {
  const std::string value = text;
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
  std::istringstream stream(text);
  std::vector<double> out;
  for (double x; stream >> x;)
    out.push_back(x);
  if (out.size() != count || !stream.eof())
    throw InputError("the header of the mask cannot be read", path + ": " + what, value.empty() ? "missing" : value,
                     "give a three-dimensional image with " + std::to_string(count) + " numbers here");
  return out;
}

Eigen::Matrix4d affine(const std::vector<double>& columns, const std::vector<double>& scale,
                       const std::vector<double>& origin) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      m(i, j) = columns[static_cast<std::size_t>(3 * j + i)] * scale[static_cast<std::size_t>(j)];
  for (int i = 0; i < 3; ++i)
    m(i, 3) = origin[static_cast<std::size_t>(i)];
  return m;
}

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

// Throws InputError if the file with the voxels is too short for `bytes`. `data` is the name of this file, beside the
// header. If the name is empty, the voxels are in the header's file. `packed` says that they are compressed.
void check_length(const std::filesystem::path& header, const std::string& data, std::uintmax_t bytes, bool packed) {
  const std::filesystem::path file = data.empty() ? header : header.parent_path() / data;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error || (packed ? largest_packing_ratio * size : size) < bytes)
    throw InputError("the mask is incomplete", file.string(),
                     (error ? "no such file" : std::to_string(size) + " bytes") + ", the header promises " +
                         std::to_string(bytes),
                     error ? "keep the file of the voxels beside its header, or export both as one file (.nrrd, .mha)"
                           : "copy or export the mask again");
}

// Unpacks the compressed voxels as a check, since VTK's reader of MetaImage never returns if they are damaged. They
// begin at byte `begin` of the file and must give `bytes` bytes.
void check_packing(const std::filesystem::path& path, std::streamoff begin, std::uintmax_t bytes) {
  const auto refuse = [&](const std::string& value) {
    throw InputError("the mask is damaged", path.string(), value + ", the header promises " + std::to_string(bytes),
                     "copy or export the mask again");
  };
  std::ifstream file(path, std::ios::binary);
  file.seekg(begin);
  z_stream stream{};
  if (inflateInit2(&stream, MAX_WBITS + 32) != Z_OK) // accepts zlib and gzip
    throw std::bad_alloc();
  const std::unique_ptr<z_stream, decltype(&inflateEnd)> ends(&stream, inflateEnd);
  std::vector<unsigned char> packed(1 << 16), voxels(1 << 18);
  std::uintmax_t found = 0;
  for (int state = Z_OK; state != Z_STREAM_END;) {
    if (stream.avail_in == 0) {
      file.read(reinterpret_cast<char*>(packed.data()), static_cast<std::streamsize>(packed.size()));
      stream.next_in = packed.data();
      stream.avail_in = static_cast<uInt>(file.gcount());
      if (stream.avail_in == 0)
        refuse("its packed voxels end after " + std::to_string(found) + " bytes");
    }
    stream.next_out = voxels.data();
    stream.avail_out = static_cast<uInt>(voxels.size());
    state = inflate(&stream, Z_NO_FLUSH);
    found += voxels.size() - stream.avail_out;
    if (state != Z_OK && state != Z_STREAM_END)
      refuse("its packed voxels cannot be unpacked beyond " + std::to_string(found) + " bytes");
  }
  if (found != bytes)
    refuse(std::to_string(found) + " bytes of voxels");
}

// Checks the fields that VTK's reader of NRRD needs. If one is missing or has an unknown form, the reader uses
// uninitialised memory or never returns.
void check_nrrd_fields(const std::string& path, const Fields& fields) {
  const auto check = [&](const std::string& name, const std::set<std::string>& known) {
    if (const std::string value = trimmed(field(fields, {name})); !known.contains(value))
      throw InputError("the header of the mask cannot be read", path + ": " + name, value.empty() ? "missing" : value,
                       "export the mask again, raw or packed by gzip");
  };
  check("type", {"signed char",
                 "int8",
                 "int8_t",
                 "uchar",
                 "unsigned char",
                 "uint8",
                 "uint8_t",
                 "short",
                 "short int",
                 "signed short",
                 "signed short int",
                 "int16",
                 "int16_t",
                 "ushort",
                 "unsigned short",
                 "unsigned short int",
                 "uint16",
                 "uint16_t",
                 "int",
                 "signed int",
                 "int32",
                 "int32_t",
                 "uint",
                 "unsigned int",
                 "uint32",
                 "uint32_t",
                 "longlong",
                 "long long",
                 "long long int",
                 "signed long long",
                 "signed long long int",
                 "int64",
                 "int64_t",
                 "ulonglong",
                 "unsigned long long",
                 "unsigned long long int",
                 "uint64",
                 "uint64_t",
                 "float",
                 "double"});
  const std::string type = trimmed(field(fields, {"type"}));
  const bool one_byte = type.ends_with("char") || type.ends_with("int8") || type.ends_with("int8_t");
  if (!one_byte)
    check("endian", {"little", "big"});
  const std::string data = trimmed(field(fields, {"data file", "datafile"}));
  // VTK's reader fails on voxels written as text in two cases. If they are in the header's file, it reads the header as
  // voxels. If their type has one byte, it reads each character as a label.
  if (one_byte || data.empty())
    check("encoding", {"raw", "gz", "gzip"});
  else
    check("encoding", {"raw", "txt", "text", "ascii", "gz", "gzip"});
  for (const double n : numbers(field(fields, {"sizes"}), 3, "sizes", path))
    if (!(n >= 1 && n <= largest_axis && n == std::floor(n)))
      throw InputError("the header of the mask cannot be read", path + ": sizes", field(fields, {"sizes"}),
                       "give a three-dimensional image of whole numbers of voxels, " + std::to_string(largest_axis) +
                           " along an axis at most");
  if (data.empty() && path.ends_with(".nhdr"))
    throw InputError("the header of the mask cannot be read", path + ": data file", "missing",
                     "name the file with the voxels there, or export the mask as one file (.nrrd)");
}

const std::vector<double> identity{1, 0, 0, 0, 1, 0, 0, 0, 1}, ones{1, 1, 1}, zeros{0, 0, 0};

} // namespace

Eigen::Matrix4d nrrd_affine(const std::string& path) {
  check_nrrd_lines(path);
  const Fields fields = header_of(path, ':', "");
  if (numbers(field(fields, {"dimension"}), 1, "dimension", path)[0] != 3)
    throw InputError("the mask is not three-dimensional", path, "dimension" + field(fields, {"dimension"}),
                     "give one label for each voxel: in 3D Slicer export the segmentation to a labelmap volume and "
                     "save that");
  check_nrrd_fields(path, fields);
  const std::string directions = field(fields, {"space directions"}), origin = field(fields, {"space origin"}),
                    spacings = field(fields, {"spacings"});
  const auto at = origin.empty() ? zeros : numbers(origin, 3, "space origin", path);
  if (!directions.empty())
    return affine(numbers(directions, 9, "space directions", path), ones, at);
  return affine(identity, spacings.empty() ? ones : numbers(spacings, 3, "spacings", path), at);
}

Eigen::Matrix4d meta_affine(const std::string& path) {
  check_meta_lines(path);
  const Fields fields = header_of(path, '=', "ElementDataFile");
  const std::string turn = field(fields, {"TransformMatrix", "Rotation", "Orientation"}),
                    origin = field(fields, {"Offset", "Origin", "Position"}),
                    spacing = field(fields, {"ElementSpacing", "ElementSize"});
  return affine(turn.empty() ? identity : numbers(turn, 9, "TransformMatrix", path),
                spacing.empty() ? ones : numbers(spacing, 3, "ElementSpacing", path),
                origin.empty() ? zeros : numbers(origin, 3, "Offset", path));
}

void check_nrrd_length(const std::string& path, std::uintmax_t bytes) {
  const Fields fields = header_of(path, ':', "");
  check_length(path, trimmed(field(fields, {"data file", "datafile"})), bytes,
               trimmed(field(fields, {"encoding"})) != "raw");
}

void check_meta_length(const std::string& path, std::uintmax_t bytes) {
  const Fields fields = header_of(path, '=', "ElementDataFile");
  const std::string data = trimmed(field(fields, {"ElementDataFile"}));
  const bool packed =
      trimmed(field(fields, {"CompressedData"})) == "True" || trimmed(field(fields, {"BinaryData"})) == "False";
  if (data.find_first_of(" %") != std::string::npos || data == "LIST") // one file for each slice: not checked
    return;
  check_length(path, data == "LOCAL" ? "" : data, bytes, packed);
  if (trimmed(field(fields, {"CompressedData"})) != "True" || !field(fields, {"HeaderSize"}).empty())
    return;
  if (data == "LOCAL")
    check_packing(path, length_of_header(path, "ElementDataFile"), bytes);
  else
    check_packing(std::filesystem::path(path).parent_path() / data, 0, bytes);
}

void check_nifti_length(const std::string& path, std::uintmax_t bytes) {
  check_length(path, "", bytes, std::filesystem::path(path).extension() == ".gz");
}

} // namespace anatomy
