#include "vci/results/output.hpp"
#include "common/error.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <unistd.h>

namespace vci {

namespace fs = std::filesystem;

namespace {

constexpr const char* partial_prefix = ".partial-"; // + process number: folder of a run's files until they are complete
constexpr const char* result_files[] = {"lumen.vtp", "lumen.stl", "coarse_lumen.vtp",
                                        "deployment.json"}; // in the order of publication, after devices/*.vtp

/// The results that are in a folder.
std::vector<fs::path> find_results(const fs::path& folder) {
  std::vector<fs::path> found;
  for (const char* name : result_files)
    if (fs::exists(folder / name))
      found.push_back(folder / name);
  if (fs::is_directory(folder / "devices"))
    for (const auto& entry : fs::directory_iterator(folder / "devices"))
      if (entry.path().extension() == ".vtp")
        found.push_back(entry.path());
  return found;
}

/// Removes the temporary folders of runs ended by a signal, recognised by a process number that no longer exists.
void remove_stale_folders(const fs::path& folder) {
  const std::string start = partial_prefix;
  for (const auto& entry : std::vector<fs::directory_entry>(fs::directory_iterator(folder), fs::directory_iterator())) {
    const std::string name = entry.path().filename().string(),
                      number = name.substr(std::min(name.size(), start.size()));
    const bool ours = name.rfind(start, 0) == 0 && !number.empty() && number.size() < 10 && entry.is_directory() &&
                      std::all_of(number.begin(), number.end(), [](unsigned char c) { return std::isdigit(c); });
    if (ours && std::stoi(number) > 0 && kill(std::stoi(number), 0) != 0 && errno == ESRCH)
      fs::remove_all(entry.path());
  }
}

} // namespace

OutputFolder::OutputFolder(fs::path out, const std::vector<fs::path>& inputs)
    : out_(std::move(out)), partial_(out_ / (partial_prefix + std::to_string(getpid()))) {
  try {
    fs::create_directories(out_);
    remove_stale_folders(out_);
    const std::vector<fs::path> earlier = find_results(out_);
    for (const fs::path& file : earlier)
      for (const fs::path& input : inputs)
        if (fs::exists(input) && fs::equivalent(file, input))
          throw common::InputError("results would replace what they are made of", out_.string(), input.string(),
                                   "name another folder with --out");
    for (const fs::path& file : earlier)
      fs::remove(file);
    fs::create_directories(partial_ / "devices");
  } catch (const fs::filesystem_error& e) {
    throw common::InputError("the folder for results cannot be written", out_.string(), e.code().message(),
                             "name a folder of yours with --out");
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored; // a leftover temporary folder must not hide the error being handled
  fs::remove_all(partial_, ignored);
}

void OutputFolder::publish() const {
  fs::create_directories(out_ / "devices");
  for (const auto& entry : fs::directory_iterator(partial_ / "devices"))
    fs::rename(entry.path(), out_ / "devices" / entry.path().filename());
  for (const char* name : result_files)
    if (fs::exists(partial_ / name))
      fs::rename(partial_ / name, out_ / name);
}

void remove_stale_result(const fs::path& out, const fs::path& scene) {
  std::error_code ignored; // the refusal that is being reported matters more
  const fs::path result = out / "deployment.json";
  if (!fs::equivalent(result, scene, ignored))
    fs::remove(result, ignored);
}

void write_json(const fs::path& file, const nlohmann::json& document) {
  std::ofstream stream(file);
  stream << document.dump(1) << '\n';
  stream.close(); // the rest of the text is written only now, so a full disk is noticed here
  if (!stream)
    throw common::WriteError(file.string());
}

} // namespace vci
