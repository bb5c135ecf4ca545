// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/capture_account.h"

#include <algorithm>

namespace sheen {

void CaptureAccount::note(const Capture& capture, const IngestReport& report) {
  captures_.push_back({capture.source_session, capture.sequence, report.status, report.reason, report.repeated,
                       report.patches_skipped, capture.photometry.has_value(),
                       capture.photometry && !capture.photometry->vignette.none(), report.exposure_gain});
  if (poses_noted_) captures_.back().camera_from_object = capture.pose.camera_from_object;
  if (report.status == IngestStatus::kRefused) ++counts_.refused[report.reason];
  if (report.status == IngestStatus::kHeldOut) ++counts_.held_out;
  if (report.status != IngestStatus::kAccepted) return;
  ++counts_.accepted;
  double total_s = 0;
  for (const auto& [stage, ms] : report.stage_ms) {
    stages_[stage].add(1e-3 * ms);
    total_s += 1e-3 * ms;
  }
  updates_.add(total_s);
  patches_.updated += report.patches_updated;
  patches_.skipped += report.patches_skipped;
  patches_.left_out += report.patches_left_out;
}

CaptureAccount::PhotometricCounts CaptureAccount::photometric() const {
  PhotometricCounts counts;
  for (const KnownCapture& known : captures_) {
    counts.response += known.response_known;
    counts.vignette += known.vignette_known;
    counts.nothing += !known.response_known;
  }
  return counts;
}

const KnownCapture* CaptureAccount::find(const Capture& capture) const {
  const auto known = std::find_if(captures_.begin(), captures_.end(), [&](const KnownCapture& other) {
    return other.source_session == capture.source_session && other.sequence == capture.sequence;
  });
  return known == captures_.end() ? nullptr : &*known;
}

void CaptureAccount::withdraw(const KnownCapture& known) {
  switch (known.status) {
    case IngestStatus::kRefused:
      if (--counts_.refused[known.reason] == 0) counts_.refused.erase(known.reason);
      break;
    case IngestStatus::kHeldOut:
      --counts_.held_out;
      break;
    case IngestStatus::kAccepted:
      if (known.repeated) patches_.skipped -= known.patches_skipped;
      --counts_.accepted;
      break;
  }
  captures_.erase(captures_.begin() + (&known - captures_.data()));
  ++counts_.withdrawn;
}

void CaptureAccount::leave_out(std::uint64_t captures) {
  counts_.received += captures;
  counts_.withdrawn += captures;
}

void CaptureAccount::refuse_damaged(std::uint64_t captures) {
  if (captures == 0) return;
  counts_.received += captures;
  counts_.refused["damaged file"] += captures;
}

void CaptureAccount::forget_accepted() {
  counts_.accepted = 0;
  std::erase_if(captures_, [](const KnownCapture& known) { return known.status == IngestStatus::kAccepted; });
  stages_.clear();
  updates_ = {};
  patches_ = {};
}

double CaptureAccount::images_per_s() const {
  return updates_.sum_s() > 0 ? static_cast<double>(updates_.count()) / updates_.sum_s() : 0;
}

}  // namespace sheen
