// Reads the elements and arrays of a .vtp file. A size that an element claims is checked against the file's size.
#pragma once
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

namespace common {

/// Says what is wrong with a file's data. check_vtp reports it as the value of an InputError.
struct DamagedFile : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// VTK's parser of XML data files, extended to check claimed sizes before it allocates memory.
class VtpArrays : public vtkXMLDataParser {
public:
  static VtpArrays* New();
  /// Parses the elements. Throws DamagedFile if they are not XML, or are nested in more than 16 levels. VTK deletes
  /// nested elements by recursion, which could overflow the stack.
  void parse(std::istream& stream, std::uint64_t file_size);
  /// The first `count` values of an array, as the bytes that VTK's reader would store. An array of texts (VTK_STRING)
  /// is read whole.
  /// Throws DamagedFile if the file holds fewer values, or if the header of binary data is malformed.
  /// @param type VTK's number of the values' type, for example VTK_DOUBLE
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

  std::uint64_t file_size_ = 0, max_expansion_ = 1; // bytes; most bytes that one compressed byte can expand to
  int skipped_ = 0;                                 // number of open elements that lie too deep
  bool too_deep_ = false;
};

} // namespace common
