#include "vci/output.hpp"
#include "common/error.hpp"

#include <fstream>
#include <unistd.h>

namespace vci {

namespace fs = std::filesystem;

namespace {

constexpr const char* results[] = {"lumen.vtp", "lumen.stl", "devices", "deployment.json"};

} // namespace

Output::Output(fs::path out) : out_(std::move(out)), partial_(out_ / (".partial-" + std::to_string(getpid()))) {
  try {
    fs::create_directories(out_);
    for (const char* name : results)
      fs::remove_all(out_ / name);
    fs::create_directories(partial_ / "devices");
  } catch (const fs::filesystem_error& e) {
    throw common::InputError("the folder for results cannot be written", out_.string(), e.code().message(),
                             "name a folder of yours with --out");
  }
}

Output::~Output() {
  std::error_code ignored; // a leftover temporary folder is no reason to hide the error under way
  fs::remove_all(partial_, ignored);
}

void Output::publish() const {
  for (const char* name : results)
    if (fs::exists(partial_ / name))
      fs::rename(partial_ / name, out_ / name);
}

void write_json(const fs::path& file, const nlohmann::json& document) {
  std::ofstream stream(file);
  stream << document.dump(1) << '\n';
  stream.close(); // what is left of the text is written only now
  if (!stream)
    throw common::ComputationError("a file cannot be written", file.string(), "", "check the folder and free space");
}

} // namespace vci
