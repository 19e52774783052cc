#include "vci/scene/files/reading.hpp"
#include "common/vtk/vtp_check.hpp"

#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkStringOutputWindow.h>
#include <vtkXMLPolyDataReader.h>

namespace vci {

namespace {

/// While it exists, VTK's errors are recorded instead of printed.
class VtkErrorRecorder {
public:
  VtkErrorRecorder() : previous_(vtkOutputWindow::GetInstance()) {
    vtkOutputWindow::SetInstance(recorded_);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  }
  ~VtkErrorRecorder() {
    vtkOutputWindow::SetInstance(previous_);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_INFO); // VTK's default
  }
  VtkErrorRecorder(const VtkErrorRecorder&) = delete;
  VtkErrorRecorder& operator=(const VtkErrorRecorder&) = delete;
  /// Text of the first error, without the place in VTK's sources and the object's address. Empty if there is no error.
  std::string first_error() const {
    const std::string all = recorded_->GetOutput();
    const std::size_t error = all.find("ERROR: "), address = all.find("): ", error);
    if (error == std::string::npos)
      return {};
    const std::size_t from = address == std::string::npos ? error : address + 3;
    return all.substr(from, all.find('\n', from) - from);
  }

private:
  vtkNew<vtkStringOutputWindow> recorded_;
  vtkSmartPointer<vtkOutputWindow> previous_;
};

} // namespace

vtkSmartPointer<vtkPolyData> read_polydata(const std::filesystem::path& file, const std::string& what) {
  if (!std::filesystem::exists(file))
    throw common::InputError("the " + what + " does not exist", file.string(), "no such file",
                             "run the anatomy step first");
  if (!std::filesystem::is_regular_file(file))
    throw common::InputError("the " + what + " is no file", file.string(),
                             std::filesystem::is_directory(file) ? "a folder" : "a device or pipe",
                             "name the .vtp file itself");
  const VtkErrorRecorder recorder;
  vtkNew<vtkXMLPolyDataReader> reader;
  if (!reader->CanReadFile(file.c_str()))
    throw common::InputError("the " + what + " is no VTK file of polygons or lines", file.string(),
                             "no readable XML of type PolyData", "name a .vtp file, as the anatomy step writes it");
  common::check_vtp(file, what);
  reader->SetFileName(file.c_str());
  reader->Update();
  if (const std::string error = recorder.first_error(); !error.empty())
    throw common::InputError("the " + what + " cannot be read", file.string(), error, "it is damaged: write it anew");
  return reader->GetOutput();
}

} // namespace vci
