// The files of an anatomy folder (docs/design.md), each written under a temporary name and moved into place.
#pragma once
#include "app/arrays.hpp"
#include "core/step_timer.hpp"
#include "remesh/remesh.hpp"
#include <filesystem>
#include <nlohmann/json.hpp>

namespace anatomy {

/// All results of `lumen process`.
struct Anatomy {
  std::string source_path, source_sha256, units;
  double edge = 0;
  Mesh mesh; ///< tags by the convention
  std::vector<End> ends;
  std::vector<Branch> branches;
  std::vector<Section> sections;
  std::vector<ReferenceProfile> profiles;
  std::vector<Lesion> lesions;
  std::vector<Repair> repairs;
  Arrays arrays;
  Quality quality;
};

/// Throws InputError if `folder` cannot be made or written. Call it before long work.
void check_folder(const std::string& folder);

/// Writes lumen.vtp, centreline.vtp, sections.csv and anatomy.json to `folder`, made if absent.
void write_anatomy(const Anatomy& anatomy, const StepTimer& timer, const std::string& folder);

/// The document of anatomy.json.
nlohmann::ordered_json summary(const Anatomy& anatomy, const StepTimer& timer);

/// Throws InputError if the file cannot be written.
void write_text(const std::filesystem::path& path, const std::string& text);

} // namespace anatomy
