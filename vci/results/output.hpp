// The folder of a run's results, which appear together or not at all.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace vci {

class OutputFolder {
public:
  /// Creates the folder. Removes an earlier run's results from it, and partial results of runs that a signal ended.
  /// Throws common::InputError if files cannot be written there, or if one of the `inputs` would be removed.
  OutputFolder(std::filesystem::path out, const std::vector<std::filesystem::path>& inputs);
  ~OutputFolder(); ///< removes unpublished files
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  /// Folder of the results until they are published; it has a folder `devices`.
  const std::filesystem::path& folder() const { return partial_; }
  /// Moves the results into place, deployment.json last.
  void publish() const;

private:
  std::filesystem::path out_, partial_;
};

/// Removes an earlier deployment.json from the folder `out` of a run that is refused before its inputs are known.
/// Without this file the others in the folder do not count as results. Keeps the file if it is the `scene` itself.
void remove_stale_result(const std::filesystem::path& out, const std::filesystem::path& scene);

/// Writes a JSON document. Throws common::ComputationError if the file is not written completely.
void write_json(const std::filesystem::path& file, const nlohmann::json& document);

} // namespace vci
