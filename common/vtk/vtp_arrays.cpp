#include "common/vtk/vtp_arrays.hpp"

#include <algorithm>
#include <cstring>
#include <vtkAbstractArray.h>
#include <vtkInputStream.h>
#include <vtkLZ4DataCompressor.h>
#include <vtkLZMADataCompressor.h>
#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>
#include <vtkZLibDataCompressor.h>

namespace common {

vtkStandardNewMacro(VtpArrays);

namespace {

// Most levels of nested elements. VTK writes 8 at most: a value in an array's information lies that deep.
constexpr unsigned int max_nesting = 16;

bool is_ascii(vtkXMLDataElement* array) {
  const char* format = array->GetAttribute("format");
  return !array->GetAttribute("offset") && !(format && std::strcmp(format, "binary") == 0);
}

} // namespace

void VtpArrays::StartElement(const char* name, const char** attributes) {
  if (skipped_ > 0 || NumberOfOpenElements >= max_nesting) {
    too_deep_ = true;
    ++skipped_;
  } else {
    vtkXMLDataParser::StartElement(name, attributes);
  }
}

void VtpArrays::EndElement(const char* name) {
  if (skipped_ > 0)
    --skipped_;
  else
    vtkXMLDataParser::EndElement(name);
}

void VtpArrays::parse(std::istream& stream, std::uint64_t file_size) {
  file_size_ = file_size;
  SetStream(&stream);
  if (!Parse() || !GetRootElement())
    throw DamagedFile("no well-formed XML");
  if (too_deep_)
    throw DamagedFile("elements more than " + std::to_string(max_nesting) + " deep in one another");
  set_compressor();
}

/// Sets the compressor that VTK's reader will choose, and the most bytes that one compressed byte can expand to: 1032
/// for deflate (zlib), 255 for LZ4. For LZMA some 7000 were measured.
void VtpArrays::set_compressor() {
  const char* name = GetRootElement()->GetAttribute("compressor");
  if (!name)
    return;
  vtkSmartPointer<vtkDataCompressor> compressor;
  if (std::strcmp(name, "vtkZLibDataCompressor") == 0) {
    compressor = vtkSmartPointer<vtkZLibDataCompressor>::New();
    max_expansion_ = 1032;
  } else if (std::strcmp(name, "vtkLZ4DataCompressor") == 0) {
    compressor = vtkSmartPointer<vtkLZ4DataCompressor>::New();
    max_expansion_ = 255;
  } else if (std::strcmp(name, "vtkLZMADataCompressor") == 0) {
    compressor = vtkSmartPointer<vtkLZMADataCompressor>::New();
    max_expansion_ = 8192;
  } else {
    throw DamagedFile(std::string("an unknown compressor, ") + name);
  }
  SetCompressor(compressor);
}

/// Moves to the start of an array's binary data, for reading from DataStream.
void VtpArrays::seek(vtkXMLDataElement* array) {
  Stream->clear(); // an earlier read may have set the end-of-file state
  if (array->GetAttribute("offset")) {
    long long offset = 0;
    array->GetScalarAttribute("offset", offset);
    if (offset < 0 || static_cast<std::uint64_t>(offset) > file_size_)
      throw DamagedFile("data that begin outside the file");
    DataStream = AppendedDataStream;
    SeekG(AppendedDataPosition + offset);
  } else {
    DataStream = InlineDataStream;
    SeekInlineDataPosition(array);
  }
  DataStream->SetStream(Stream);
}

/// The first `words` whole numbers, of 4 or 8 bytes each, of an array's binary data. Empty if the array has fewer.
/// Throws DamagedFile if the whole file is too short for them.
std::vector<std::uint64_t> VtpArrays::header(vtkXMLDataElement* array, std::uint64_t words) {
  const std::size_t width = HeaderType / 8;
  if (words > file_size_ / width)
    throw DamagedFile("more blocks than the file has bytes");
  std::vector<unsigned char> bytes(words * width);
  seek(array);
  DataStream->StartReading();
  const std::size_t read = DataStream->Read(bytes.data(), bytes.size());
  DataStream->EndReading();
  if (read < bytes.size())
    return {};
  PerformByteSwap(bytes.data(), words, width);
  std::vector<std::uint64_t> result(words);
  for (std::size_t k = 0; k < words; ++k)
    if (width == 4) {
      std::uint32_t word;
      std::memcpy(&word, &bytes[4 * k], 4);
      result[k] = word;
    } else {
      std::memcpy(&result[k], &bytes[8 * k], 8);
    }
  return result;
}

/// Number of bytes of an array's uncompressed data, as the header before the data claims. 0 if there is no header.
/// Throws DamagedFile if the file is too small for the claim.
std::uint64_t VtpArrays::uncompressed_bytes(vtkXMLDataElement* array) {
  if (!Compressor) {
    const auto length = header(array, 1);
    if (!length.empty() && length[0] > file_size_)
      throw DamagedFile("more data than the file has bytes");
    return length.empty() ? 0 : length[0];
  }
  const auto start = header(array, 3);
  if (start.empty())
    return 0;
  const std::uint64_t blocks = start[0], block = start[1], last = start[2];
  if (blocks == 0) {
    if (last != 0)
      throw DamagedFile("a block of data that is not there");
    return 0;
  }
  if (block == 0 || last > block)
    throw DamagedFile("a block of data of no size, or a last one larger than the others");
  const auto sizes = header(array, blocks + 3);
  if (sizes.empty())
    throw DamagedFile("fewer sizes of blocks than blocks");
  std::uint64_t stored = 0;
  for (std::size_t k = 3; k < sizes.size(); ++k) {
    if (sizes[k] > file_size_)
      throw DamagedFile("a block of data larger than the file");
    stored += sizes[k];
  }
  const std::uint64_t most = std::min(stored, file_size_) * max_expansion_, whole = last > 0 ? blocks - 1 : blocks;
  if (last > most || (whole > 0 && block > (most - last) / whole))
    throw DamagedFile("blocks of data that claim to hold more than they can");
  return whole * block + last;
}

std::vector<unsigned char> VtpArrays::read_ascii(vtkXMLDataElement* array, int type, std::uint64_t count) {
  if (count > file_size_)
    throw DamagedFile("more values than the file has bytes");
  std::vector<unsigned char> values(count * GetWordTypeSize(type));
  Stream->clear();
  if (count > 0)
    values.resize(ReadInlineData(array, 1, values.data(), 0, count, type) * GetWordTypeSize(type));
  return values;
}

std::vector<unsigned char> VtpArrays::read(vtkXMLDataElement* array, int type, std::uint64_t count) {
  const bool is_text = type == VTK_STRING;
  const int word = is_text ? VTK_CHAR : type;
  const std::uint64_t width = vtkAbstractArray::GetDataTypeSize(word);
  std::vector<unsigned char> values;
  if (is_ascii(array)) {
    values = read_ascii(array, word, is_text ? file_size_ : count);
  } else {
    const std::uint64_t bytes = uncompressed_bytes(array);
    if (!is_text && count > bytes / width)
      throw DamagedFile("fewer data than the element claims");
    values.resize(is_text ? bytes : count * width);
    seek(array);
    if (Compressor) {
      if (!values.empty() && ReadBinaryData(values.data(), 0, values.size() / width, word) != values.size() / width)
        throw DamagedFile("a block of data that cannot be read");
    } else {
      // VTK's decoder accepts data of which only the first byte is there, and leaves the other bytes uninitialised.
      std::vector<unsigned char> all(HeaderType / 8 + values.size());
      DataStream->StartReading();
      const std::size_t read = DataStream->Read(all.data(), all.size());
      DataStream->EndReading();
      if (!values.empty() && read < all.size())
        throw DamagedFile("data that end before their length");
      std::copy(all.end() - static_cast<std::ptrdiff_t>(values.size()), all.end(), values.begin());
      PerformByteSwap(values.data(), values.size() / width, width);
    }
  }
  if (!is_text && values.size() / width < count)
    throw DamagedFile("fewer data than the element claims");
  // VTK's reader stores all texts that it finds, even those past the end of the array.
  if (is_text && static_cast<std::uint64_t>(std::count(values.begin(), values.end(), 0)) != count)
    throw DamagedFile("another number of texts than the element claims");
  return values;
}

} // namespace common
