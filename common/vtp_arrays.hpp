// Reads the elements of a .vtp file and its arrays without trusting claimed sizes beyond the file's own.
#pragma once
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

namespace common {

/// What is wrong with a file's data, for the value of an InputError.
struct Damaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// VTK's parser, as its reader uses it, but it checks claimed sizes before it allocates memory.
class VtpArrays : public vtkXMLDataParser {
public:
  static VtpArrays* New();
  /// Parses the elements. Throws Damaged where they are no XML, or lie deeper in one another than VTK's elements may,
  /// which end by recursion.
  void parse(std::istream& stream, std::uint64_t file_size);
  /// The first `count` values of an array as bytes, as VTK's reader reads them. An array of type String is read whole.
  /// Throws Damaged if the file holds fewer values, or if the header of binary data is malformed.
  /// @param type as VTK numbers types, for example VTK_DOUBLE
  std::vector<unsigned char> read(vtkXMLDataElement* array, int type, std::uint64_t count);

protected:
  void StartElement(const char* name, const char** attributes) override;
  void EndElement(const char* name) override;

private:
  void seek(vtkXMLDataElement* array);
  std::vector<std::uint64_t> header(vtkXMLDataElement* array, std::uint64_t words);
  std::uint64_t uncompressed_bytes(vtkXMLDataElement* array);
  std::vector<unsigned char> read_ascii(vtkXMLDataElement* array, int type, std::uint64_t count);
  void set_compressor();

  std::uint64_t file_size_ = 0, most_per_byte_ = 1; // bytes; most bytes from one compressed byte
  int skipped_ = 0;                                 // elements too deep that are not yet closed
  bool too_deep_ = false;
};

} // namespace common
