// The folder of a run's results, which appear together or not at all.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace vci {

class Output {
public:
  /// Creates the folder and removes an earlier run's results from it, before any work. Also removes partial results of
  /// runs that a signal ended. Throws common::InputError if files cannot be written there, or if it would remove one of
  /// the `inputs`.
  Output(std::filesystem::path out, const std::vector<std::filesystem::path>& inputs);
  ~Output(); ///< removes unpublished files
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  /// Folder of the results until they are published; it has a folder `devices`.
  const std::filesystem::path& folder() const { return partial_; }
  /// Moves the results into place, deployment.json last.
  void publish() const;

private:
  std::filesystem::path out_, partial_;
};

/// Removes deployment.json from the folder of a run that is refused before its inputs are known, because other files
/// there do not count as results without it. Keeps the file if it is the `scene` itself.
void withdraw(const std::filesystem::path& out, const std::filesystem::path& scene);

/// Throws common::ComputationError if the file is not written completely.
void write_json(const std::filesystem::path& file, const nlohmann::json& document);

} // namespace vci
