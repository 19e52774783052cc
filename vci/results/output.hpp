// The folder of a run's results, which appear together or not at all.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace vci {

class Output {
public:
  /// Creates the folder and takes an earlier run's results out of it, before any work, and what runs left there that a
  /// signal ended. Throws common::InputError where files cannot be written there, and where one of the `inputs` would
  /// be taken out.
  Output(std::filesystem::path out, const std::vector<std::filesystem::path>& inputs);
  ~Output(); ///< removes what was not published
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  /// Where results are written until they are published; it has a folder `devices`.
  const std::filesystem::path& folder() const { return partial_; }
  /// Moves the results into place, deployment.json last.
  void publish() const;

private:
  std::filesystem::path out_, partial_;
};

/// Takes deployment.json, without which nothing there counts as results, out of a folder whose run is refused before
/// its inputs are known; not where it is the `scene` itself.
void withdraw(const std::filesystem::path& out, const std::filesystem::path& scene);

/// Throws common::ComputationError where not all of it is written.
void write_json(const std::filesystem::path& file, const nlohmann::json& document);

} // namespace vci
