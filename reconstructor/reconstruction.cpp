// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/reconstruction.h"

#include <algorithm>

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
      account(report);
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

bool Reconstruction::withdraw(const Capture& capture) {
  if (model_.began_with(capture)) return false;
  const auto held_out = std::find_if(held_out_.begin(), held_out_.end(), [&](const HeldOutView& view) {
    return view.source_session == capture.source_session && view.sequence == capture.sequence;
  });
  if (held_out != held_out_.end()) {
    held_out_.erase(held_out);
    --counts_.held_out;
  } else {
    if (!model_.withdraw(capture)) return false;
    --counts_.accepted;
  }
  ++counts_.withdrawn;
  return true;
}

void Reconstruction::leave_out(std::uint64_t captures) {
  counts_.received += captures;
  counts_.withdrawn += captures;
}

void Reconstruction::restart() {
  model_.restart();
  held_out_.clear();
  counts_ = {};
  stages_.clear();
  updates_ = {};
}

void Reconstruction::account(const IngestReport& report) {
  double total_s = 0;
  for (const auto& [stage, ms] : report.stage_ms) {
    stages_[stage].add(1e-3 * ms);
    total_s += 1e-3 * ms;
  }
  updates_.add(total_s);
}

double Reconstruction::images_per_s() const {
  return updates_.sum_s() > 0 ? static_cast<double>(updates_.count()) / updates_.sum_s() : 0;
}

Reconstruction::Judgement Reconstruction::judge() {
  return {score(held_out_, *fill_unseen(*snapshot()), painter_), score(held_out_, *model_.constant_colour(), painter_)};
}

}  // namespace sheen
