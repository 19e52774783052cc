#include "mask/nifti_check.hpp"
#include "common/error.hpp"
#include "mask/mask_header.hpp"
#include <array>
#include <memory>
#include <set>
#include <zlib.h>

namespace anatomy {
namespace {

using common::InputError;

// NIfTI's code of each accepted scalar type, and its bits per voxel.
const std::set<std::pair<std::int64_t, std::int64_t>> types{{2, 8},   {4, 16},   {8, 32},   {16, 32},   {64, 64},
                                                            {256, 8}, {512, 16}, {768, 32}, {1024, 64}, {1280, 64}};

// The bytes of a header, big- or little-endian. at() reads a signed integer of `size` bytes.
struct Bytes {
  std::array<unsigned char, 540> data{};
  bool big = false;
  std::int64_t at(std::size_t offset, std::size_t size) const {
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < size; ++k)
      value |= static_cast<std::uint64_t>(data[offset + (big ? size - 1 - k : k)]) << (8 * k);
    const std::uint64_t sign = std::uint64_t{1} << (8 * size - 1);
    return static_cast<std::int64_t>((value ^ sign) - sign);
  }
};

} // namespace

void check_nifti_header(const std::string& path) {
  const auto refuse = [&](const std::string& field, const std::string& value) {
    throw InputError("the header of the mask cannot be read", path + ": " + field, value,
                     "give a NIfTI file with one scalar label for each voxel of a volume");
  };
  const std::unique_ptr<gzFile_s, decltype(&gzclose)> file(gzopen(path.c_str(), "rb"), gzclose);
  Bytes header;
  const int read = file ? gzread(file.get(), header.data.data(), header.data.size()) : -1;
  if (read < 348)
    refuse("header", "incomplete");
  header.big = header.data[0] == 0;
  const std::int64_t size = header.at(0, 4);
  const bool second = size == 540; // NIfTI-2 has wider fields in another order
  if (size != 348 && (!second || read < 540))
    refuse("sizeof_hdr", std::to_string(size));
  const std::size_t dim = second ? 16 : 40, width = second ? 8 : 2;
  const std::int64_t dimensions = header.at(dim, width);
  if (dimensions < 3 || dimensions > 7)
    refuse("dim[0]", std::to_string(dimensions));
  for (std::int64_t k = 1; k <= 7; ++k) {
    const std::int64_t n = header.at(dim + static_cast<std::size_t>(k) * width, width);
    if (k <= dimensions ? n < 1 || n > largest_axis || (k > 3 && n != 1) : n > 1)
      refuse("dim[" + std::to_string(k) + "]", std::to_string(n));
  }
  const std::int64_t type = header.at(second ? 12 : 70, 2), bits = header.at(second ? 14 : 72, 2);
  if (!types.contains({type, bits}))
    refuse("datatype and bitpix", std::to_string(type) + " and " + std::to_string(bits));
}

} // namespace anatomy
