// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/panel_words.h"

#include <algorithm>
#include <cmath>

#include "common/base/format.h"
#include "reconstructor/render/gl/camera_picture.h"
#include "reconstructor/render/gl/model_drawer.h"

namespace sheen {
namespace {

unsigned long long count(std::uint64_t n) {
  return n;
}

Rgba rgba(const Eigen::Vector3f& color) {
  const auto level = [](float x) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(x, 0.0f, 1.0f))); };
  return {level(color.x()), level(color.y()), level(color.z()), 255};
}

std::string progress_of(const ViewerState& state, const SnapshotFigures* figures) {
  if (state.next_view && state.next_view->well_known) return "All of it is well known.";
  if (!figures || !(figures->seen > 0)) return "Images arrive.";
  return format("%d %% of the surface is seen.", static_cast<int>(100 * figures->seen));
}

/// What a person needs to know first, and how urgent it is.
void tell_first(const ViewerState& state, const SnapshotFigures* figures, Told& told) {
  const auto first = [&](Tone tone, std::string sentence) {
    told.tone = tone;
    told.sentence = std::move(sentence);
  };
  if (state.work) return first(Tone::kBusy, state.work->what);
  if (state.paused) return first(Tone::kWarn, "Paused: images are stored, but not added to the model.");
  switch (state.link) {
    case TrackerLink::kWaiting:
      return first(Tone::kIdle, "Waiting for a tracker.");
    case TrackerLink::kConnected:
      if (!state.trouble.empty()) return first(Tone::kBad, "The latest images cannot be used.");
      return first(Tone::kGood, progress_of(state, figures));
    case TrackerLink::kStale:
      return first(Tone::kWarn, "The camera sends nothing at the moment.");
    case TrackerLink::kEnded:
      return first(Tone::kGood, "All images have come. " + progress_of(state, figures));
    case TrackerLink::kNone:
      break;
  }
  if (!state.snapshot) return first(Tone::kIdle, "There is no model.");
  if (state.snapshot->empty()) return first(Tone::kIdle, "No image has reached the model.");
  first(Tone::kGood, progress_of(state, figures));
}

/// Where to go, or why that is not said: what the model has to say is old while images wait.
std::string next_of(const ViewerState& state, const Guidance* guidance) {
  constexpr std::uint64_t kMany = 5;
  if (state.work) return state.work->way_out;
  if (state.next_view && state.next_view->well_known) return "Done: " + state.next_view->reason;
  if (state.next_view && guidance) return "Next: " + advice_in_words(*guidance, state.next_view->reason);
  if (state.figures && state.figures->frames_waiting > kMany)
    return format("The model catches up: %llu images wait.", count(state.figures->frames_waiting));
  return {};
}

std::optional<Eigen::Vector2f> way_of(const ViewerState& state, const Guidance* guidance) {
  if (state.work || !state.next_view || !guidance) return std::nullopt;
  if (state.next_view->well_known || guidance->there()) return Eigen::Vector2f::Zero();
  return Eigen::Vector2d(guidance->right_deg, guidance->up_deg).normalized().cast<float>();
}

std::string counts_of(const ViewerState& state, const char* model) {
  std::vector<std::string> words;
  if (!state.figures) {
    if (!state.snapshot) return {};
    words.emplace_back(model);
    const std::size_t views = state.snapshot->cameras().size(), lights = state.snapshot->lights().size();
    const char* const view = lights > 0 ? "view" : "image";
    if (views > 0) words.push_back(format("%zu %s%s", views, view, views == 1 ? "" : "s"));
    if (lights > 0) words.push_back(format("%zu light%s", lights, lights == 1 ? "" : "s"));
  } else {
    const CaptureFigures& f = *state.figures;
    const std::uint64_t built = f.frames_accepted - f.frames_held_out;
    if (built > 0) words.push_back(format("%llu image%s in the model", count(built), built == 1 ? "" : "s"));
    if (f.held_out_psnr_db) words.push_back(format("%.1f dB on views it never saw", *f.held_out_psnr_db));
    if (f.frames_waiting > 1) words.push_back(format("%llu wait to be added", count(f.frames_waiting)));
  }
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : " \xc2\xb7 ") + word;
  return all;
}

ToldLine tracker_line(TrackerLink link) {
  switch (link) {
    case TrackerLink::kWaiting:
      return {"tracker", "waiting for it", Tone::kWarn};
    case TrackerLink::kConnected:
      return {"tracker", "connected", Tone::kGood};
    case TrackerLink::kStale:
      return {"tracker", "STALE: no sign of it", Tone::kBad};
    case TrackerLink::kEnded:
      return {"tracker", "the capture has ended"};
    case TrackerLink::kNone:
      break;
  }
  return {"tracker", "none: a saved model"};
}

ToldLine pose_line(const Capture& capture) {
  if (!capture.pose.usable()) return {"pose", std::string("none: ") + to_string(capture.pose.status), Tone::kBad};
  if (capture.pose.status == PoseStatus::kGiven) return {"pose", "given with the image"};
  return {"pose", format("%d of %zu tags, error %.2f px", capture.pose.tags_used, capture.tags.size(),
                         capture.pose.reprojection_rms_px)};
}

std::vector<ToldLine> frame_lines(const CaptureFigures& f) {
  std::uint64_t refused = 0;
  for (const auto& [reason, n] : f.frames_refused) refused += n;
  std::vector<ToldLine> lines{
      {"frames", format("%llu, used %llu (%llu held out), refused %llu", count(f.frames_received),
                        count(f.frames_accepted), count(f.frames_held_out), count(refused))}};
  for (const auto& [reason, n] : f.frames_refused) lines.push_back({"", format("%s %llu", reason.c_str(), count(n))});
  if (f.tracker_judged > 0) {
    std::uint64_t there = 0;
    for (const auto& [reason, n] : f.tracker_refused) there += n;
    lines.push_back({"camera", format("%llu frames, tracker refused %llu", count(f.tracker_judged), count(there))});
    for (const auto& [reason, n] : f.tracker_refused)
      lines.push_back({"", format("%s %llu", reason.c_str(), count(n))});
  }
  if (f.frames_withdrawn > 0) lines.push_back({"", format("taken back %llu", count(f.frames_withdrawn))});
  lines.push_back(f.frames_waiting > 0 && f.images_per_s > 0
                      ? ToldLine{"rate",
                                 format("%.1f images/s; %llu wait, %.0f s", f.images_per_s, count(f.frames_waiting),
                                        static_cast<double>(f.frames_waiting) / f.images_per_s),
                                 Tone::kWarn}
                      : ToldLine{"rate", format("%.1f images/s", f.images_per_s)});
  return lines;
}

std::vector<ToldLine> rank_lines(const SnapshotFigures& figures) {
  return {{"rank", format("median %.3g, most %d", figures.median_rank, figures.most_rank)},
          {"surface", format("%.1f %% seen, %.1f %% measured", 100 * figures.seen, 100 * figures.measured)}};
}

std::vector<ToldLine> error_lines(const CaptureFigures& f) {
  std::vector<ToldLine> lines;
  if (f.predicted_psnr_db) lines.push_back({"predicted", format("%.1f dB of the last image", *f.predicted_psnr_db)});
  if (f.residual) lines.push_back({"residual", format("%.1f %% of the last image", 100 * *f.residual)});
  if (!f.held_out_psnr_db) return lines;
  std::string value = format("%.1f dB", *f.held_out_psnr_db);
  if (f.held_out_ssim) value += format(", SSIM %.3f", *f.held_out_ssim);
  lines.push_back({"held out", value, Tone::kGood});
  return lines;
}

/// What is traded for what: in green what is kept, in red what is not.
std::vector<ToldLine> trade_lines(const Trade& trade) {
  std::vector<ToldLine> lines;
  const bool full = trade.effort_level == 0 && trade.update_fraction == 1;
  std::string effort = "full";
  if (!full)
    effort = format("level %d of %d, %.0f %% of each image", trade.effort_level, trade.effort_levels - 1,
                    100 * trade.update_fraction);
  if (!trade.favour.empty()) effort += ", favours " + trade.favour;
  lines.push_back({"effort", effort, full ? Tone::kIdle : Tone::kWarn});
  const auto against = [&](const char* label, const std::string& value, const std::optional<bool>& kept) {
    if (kept) lines.push_back({label, value + (*kept ? ", kept" : ", NOT KEPT"), *kept ? Tone::kGood : Tone::kBad});
  };
  if (trade.budget_ms)
    against("budget", format("%.1f of %.4g ms per image", trade.image_ms, *trade.budget_ms), trade.budget_kept());
  if (trade.memory_bytes)
    against("memory", format("%.0f of %.4g MB", 1e-6 * trade.grown_bytes, 1e-6 * *trade.memory_bytes),
            trade.memory_kept());
  if (!std::isnan(trade.health.energy_lost))
    lines.push_back({"numerics", format("orthogonal to %.1g, %.2g %% of energy lost", trade.health.orthogonality_lost,
                                        100 * trade.health.energy_lost)});
  return lines;
}

std::vector<ToldLine> all_figures(const ViewerState& state, const ViewControls& controls, const WordSources& sources) {
  std::vector<ToldLine> lines{{"model", sources.model}, tracker_line(state.link)};
  const auto add = [&](const std::vector<ToldLine>& more) { lines.insert(lines.end(), more.begin(), more.end()); };
  if (state.capture) add({pose_line(*state.capture)});
  if (state.figures) add(frame_lines(*state.figures));
  if (sources.figures) add(rank_lines(*sources.figures));
  if (state.figures) add(error_lines(*state.figures));
  if (state.figures) add(trade_lines(state.figures->trade));
  if (controls.follow) add({{"view", "follows the camera"}});
  return lines;
}

std::string legend_title(const ViewControls& controls) {
  switch (controls.mode) {
    case ViewMode::kAppearance:
      return "";
    case ViewMode::kHeuristic:
    case ViewMode::kSplit:
      return controls.reasons ? "Why images are needed" : "Where images are needed";
    case ViewMode::kCamera:
      return "Camera image";
    case ViewMode::kRank:
      return "What the scene required: terms of a patch";
    case ViewMode::kResolution:
      return "What the scene required: samples along a triangle";
    case ViewMode::kBytes:
      return "What the scene required: bytes of a triangle";
    case ViewMode::kShape:
      return "From what the shape is known";
  }
  return "";
}

std::vector<Swatch> evidence_legend(const Mesh& mesh) {
  if (mesh.evidence.empty()) return {};
  constexpr std::pair<ShapeEvidence, const char*> kWords[] = {{ShapeEvidence::kSeen, "images agree about it"},
                                                              {ShapeEvidence::kOutline, "outlines alone bound it"},
                                                              {ShapeEvidence::kGuessed, "a guess"}};
  std::vector<Swatch> swatches;
  for (const auto& [evidence, words] : kWords)
    swatches.push_back(
        {rgba(evidence_color(evidence)), format("%s: %.0f %%", words, 100 * share_known_as(evidence, mesh))});
  return swatches;
}

std::vector<Swatch> legend(const ViewerState& state, const ViewControls& controls, const WordSources& sources) {
  const std::vector<Swatch> states{{rgba(state_color(SampleState::kImputed)), "imputed: few images show it"},
                                   {rgba(state_color(SampleState::kUnseen)), "striped: a guess, no image shows it"}};
  std::vector<Swatch> swatches;
  switch (controls.mode) {
    case ViewMode::kHeuristic:
    case ViewMode::kSplit:
      if (controls.reasons) {
        swatches = {{rgba(reason_color(QualityReason::kUnseen)), "no image shows it"},
                    {rgba(reason_color(QualityReason::kOblique)), "seen at grazing angles only"},
                    {rgba(reason_color(QualityReason::kSparseDirections)), "no image from near here"},
                    {rgba(reason_color(QualityReason::kHighResidual)), "images still bring news"}};
        if (state.snapshot && !state.snapshot->mesh().evidence.empty())
          swatches.push_back({rgba(reason_color(QualityReason::kShapeGuessed)), "its shape is a guess"});
      } else {
        swatches = {{rgba(need_color(1)), "needs images: 20 dB expected"},
                    {rgba(need_color(0.5f)), "needs some: 26 dB"}};
      }
      swatches.push_back({rgba(need_color(0)), "well known"});
      if (controls.mode == ViewMode::kSplit && controls.states)
        swatches.insert(swatches.begin(), states.begin(), states.end());
      break;
    case ViewMode::kAppearance:
      if (controls.states)
        swatches = states;
      else if (sources.figures && sources.figures->seen > 0 && sources.figures->seen < 1)
        swatches = {{{52, 55, 62, 255}, "striped: no image shows it"}};
      break;
    case ViewMode::kCamera:
      if (state.capture) swatches = {{kUsedTagColor, "tag used for the pose"}, {kUnusedTagColor, "tag left out"}};
      if (state.capture && state.snapshot) swatches.push_back({kOutlineColor, "outline of the mesh at this pose"});
      break;
    case ViewMode::kRank:
    case ViewMode::kResolution:
    case ViewMode::kBytes:
      if (!sources.demand || sources.demand->empty()) break;
      for (int stop = kDemandColours - 1; stop >= 0; --stop)
        swatches.push_back({rgba(demand_stop(stop)),
                            format("%.3g%s", sources.demand->most() * static_cast<float>(stop) / (kDemandColours - 1),
                                   stop + 1 == kDemandColours ? " or more" : "")});
      break;
    case ViewMode::kShape:
      if (state.snapshot) swatches = evidence_legend(state.snapshot->mesh());
      break;
  }
  return swatches;
}

}  // namespace

Told told(const ViewerState& state, const ViewControls& controls, const WordSources& sources,
          std::vector<std::string> notes) {
  Told all;
  tell_first(state, sources.figures, all);
  all.next = next_of(state, sources.guidance);
  all.way = way_of(state, sources.guidance);
  all.counts = counts_of(state, sources.model);
  all.details = all_figures(state, controls, sources);
  all.legend = legend(state, controls, sources);
  if (!all.legend.empty()) all.legend_title = legend_title(controls);
  all.notes = std::move(notes);
  if (!state.message.empty()) all.notes.push_back(state.message);
  if (state.figures)
    for (const ToldLine& line : trade_lines(state.figures->trade))
      if (line.tone == Tone::kBad) all.notes.push_back(line.label + ": " + line.value);
  return all;
}

}  // namespace sheen
