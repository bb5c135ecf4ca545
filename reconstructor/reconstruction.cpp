// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/reconstruction.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {

Reconstruction::Reconstruction(Mesh mesh, const SurfaceLightFieldOptions& options)
    : mesh_(std::make_shared<Mesh>(std::move(mesh))), model_(mesh_, options), painter_(*mesh_) {}

IngestReport Reconstruction::ingest(const Capture& capture) {
  ++counts_.received;
  IngestReport report = model_.ingest(capture);
  switch (report.status) {
    case IngestStatus::kAccepted:
      ++counts_.accepted;
      for (const auto& [stage, ms] : report.stage_ms) stage_ms_[stage].push_back(ms);
      break;
    case IngestStatus::kHeldOut:
      ++counts_.held_out;
      held_out_.push_back(make_held_out_view(capture, report.exposure_gain, painter_));
      break;
    case IngestStatus::kRefused:
      ++counts_.refused[report.reason];
      break;
  }
  return report;
}

double Reconstruction::images_per_s() const {
  double total_ms = 0;
  for (const auto& [stage, ms] : stage_ms_) total_ms += std::accumulate(ms.begin(), ms.end(), 0.0);
  return total_ms > 0 ? 1e3 * static_cast<double>(counts_.accepted) / total_ms : 0;
}

Reconstruction::Judgement Reconstruction::judge() {
  return {score(held_out_, *fill_unseen(*snapshot()), painter_), score(held_out_, *model_.constant_colour(), painter_)};
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace sheen
