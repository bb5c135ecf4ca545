// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/shape_finding.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/errors.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "reconstructor/capture/live_shape.h"
#include "reconstructor/scene/mesh_scale.h"

namespace sheen {
namespace {

constexpr double kMostlySeen = 0.5;

}  // namespace

Option add_rough_mesh_option(Command& command, std::string& path) {
  return command.option(
      "--from-mesh", path,
      "a rough mesh of the object, in the dataset's frame: what an image shows beside it, by more than 3 % "
      "of its size, is background");
}

std::optional<Mesh> rough_mesh(const std::string& path) {
  if (path.empty()) return std::nullopt;
  return load_mesh(path).mesh;
}

FoundShape find_and_tell(const RefinementImages& images, const ShapeOptions& options, nlohmann::json& report) {
  std::optional<Progress> bar;
  FoundShape found = find_shape(images, options, [&](std::size_t done, std::size_t steps) {
    if (!bar) bar.emplace("finding the shape", steps);
    if (stop_requested()) throw Error("stopped while the shape was looked for; nothing was written");
    bar->update(done);
  });
  bar.reset();
  const double seen = share_known_as(ShapeEvidence::kSeen, found.mesh);
  const double outline = share_known_as(ShapeEvidence::kOutline, found.mesh);
  std::fprintf(stderr,
               "shape: %zu triangles, %s; of its vertices %.0f %% are seen by images, %.0f %% known by outlines, "
               "%.0f %% guessed\n",
               found.mesh.triangles.size(), size_text(found.mesh).c_str(), 100 * seen, 100 * outline,
               100 * (1 - seen - outline));
  if (found.stage_unconfirmed)
    std::fprintf(
        stderr,
        "outlines are not found by the sheet of stage.json: the images do not show its tags where the file has "
        "them, or the object is as white as the paper\n");
  const std::vector<ShapeFinding> findings = findings_of(found.measures);
  for (const ShapeFinding& finding : findings) std::fprintf(stderr, "shape: %s\n", finding.sentence.c_str());
  if (seen < kMostlySeen && findings.empty())
    std::fprintf(
        stderr,
        "most of the shape is not seen by images that agree: take more of them, in steps of 10 to 15 degrees round "
        "the object; smooth or mirror-like parts need texture or an outline (masks, a plain background)\n");
  report = {{"triangles", found.mesh.triangles.size()},
            {"vertices", found.mesh.vertices.size()},
            {"images", images.cameras.size()},
            {"views", found.views},
            {"outlines", found.outlines},
            {"outlines_agree", found.coherent},
            {"depth_share", found.depth_share},
            {"cell_mm", 1e3 * found.cell},
            {"evidence", {{"seen", seen}, {"outline", outline}, {"guessed", 1 - seen - outline}}},
            {"findings", findings_report(findings)}};
  return found;
}

}  // namespace sheen
