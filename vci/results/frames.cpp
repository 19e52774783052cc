#include "vci/results/frames.hpp"
#include "common/error.hpp"

#include <fstream>
#include <iomanip>

namespace vci {

namespace fs = std::filesystem;

namespace {

std::string numbered_file(const std::string& name, int number) {
  std::ostringstream text;
  text << name << '_' << std::setw(4) << std::setfill('0') << number << ".vtp";
  return text.str();
}

/// Whether an earlier run's FrameWriter may have written this file. Such files are removed.
bool is_frame(const fs::path& file) {
  const std::string name = file.filename().string();
  return name == "frames.pvd" || (file.extension() == ".vtp" && name.find("frame_") == 0);
}

} // namespace

std::vector<PointArray> force_arrays(const Balance& balance) {
  if (balance.residual.empty())
    return {};
  return {vector_array("pressure_n", balance.pressure), vector_array("contact_n", balance.contact),
          vector_array("foundation_n", balance.foundation), vector_array("residual_n", balance.residual)};
}

FrameWriter::FrameWriter(fs::path folder, const LumenFile& lumen) : folder_(std::move(folder)), lumen_(lumen) {
  try {
    fs::create_directories(folder_);
    for (const auto& entry : fs::directory_iterator(folder_))
      if (is_frame(entry.path()))
        fs::remove(entry.path());
  } catch (const fs::filesystem_error& e) {
    throw common::InputError("the folder for frames cannot be written", folder_.string(), e.code().message(),
                             "name a folder of yours with --frames");
  }
}

void FrameWriter::add(const Snapshot& snapshot) {
  int part = 0;
  const auto write_surface = [&](const std::string& name, const Vectors& points, const Triangles& triangles,
                                 const Balance& forces) {
    const std::string file = numbered_file("frame_" + name, count_);
    write_shape(folder_ / file, points, triangles, {}, force_arrays(forces));
    entries_ << "    <DataSet timestep=\"" << count_ << "\" part=\"" << part++ << "\" name=\"" << name << "\" file=\""
             << file << "\"/>\n";
  };
  write_surface("lumen", snapshot.lumen, lumen_.triangles, snapshot.forces);
  int number = 0;
  for (const DeviceShape& device : snapshot.devices)
    write_surface("device" + std::to_string(++number), device.points, device.triangles, device.forces);
  entries_ << "    <!-- " << count_ << ": " << snapshot.stages_done << " stages done, " << snapshot.steps
           << " steps in the latest -->\n";
  ++count_;
}

void FrameWriter::finish() const {
  std::ofstream file(folder_ / "frames.pvd");
  file << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n  <Collection>\n"
       << entries_.str() << "  </Collection>\n</VTKFile>\n";
  file.close(); // the rest of the text is written only now, so a full disk is noticed here
  if (!file)
    throw common::WriteError((folder_ / "frames.pvd").string());
}

} // namespace vci
