// Writes the files of an anatomy folder (docs/design.md). Each is written under a temporary name and moved into place.
#pragma once
#include "app/arrays.hpp"
#include "core/step_timer.hpp"
#include "files/length_unit.hpp"
#include "remesh/remesh.hpp"
#include <filesystem>
#include <nlohmann/json.hpp>

namespace anatomy {

/// All results of `lumen process`.
struct Anatomy {
  std::string source_path, source_sha256;
  LengthUnit unit = LengthUnit::mm; ///< of the source
  double edge = 0;                  ///< mm, edge length that the user asked for
  Mesh mesh;                        ///< final surface, its faces tagged as docs/design.md says
  std::vector<End> ends;
  std::vector<Branch> branches;
  std::vector<Section> sections;
  std::vector<ReferenceProfile> profiles;
  std::vector<Lesion> lesions;
  std::vector<Repair> repairs;
  LumenArrays arrays;
  Quality quality;
};

/// Writes lumen.vtp, centreline.vtp, sections.csv and anatomy.json to `folder`, which is made if it does not exist.
void write_anatomy(const Anatomy& anatomy, const StepTimer& timer, const std::string& folder);

/// The content of anatomy.json.
nlohmann::ordered_json summary(const Anatomy& anatomy, const StepTimer& timer);

/// Writes `text` to a file. Throws InputError if that fails.
void write_text(const std::filesystem::path& path, const std::string& text);

} // namespace anatomy
