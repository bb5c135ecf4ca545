// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/hud.h"

#include <algorithm>
#include <cmath>

#include "common/base/format.h"

namespace sheen {
namespace {

constexpr Rgba kText{240, 240, 240, 255}, kDim{165, 172, 182, 255}, kPanel{12, 14, 18, 190};
constexpr Rgba kGreen{90, 220, 120, 255}, kAmber{255, 190, 70, 255}, kRed{255, 90, 80, 255};

struct Line {
  std::string label, value;
  Rgba color = kText;
};

unsigned long long count(std::uint64_t n) {
  return n;
}

Rgba rgba(const Eigen::Vector3f& color) {
  const auto level = [](float x) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(x, 0.0f, 1.0f))); };
  return {level(color.x()), level(color.y()), level(color.z()), 255};
}

/// A dark box with two columns of text.
void draw_box(OverlayPainter& overlay, float x, float y, const std::vector<Line>& lines) {
  std::size_t label = 0, value = 0;
  for (const Line& line : lines) {
    label = std::max(label, line.label.size());
    value = std::max(value, line.value.size());
  }
  const float pad = overlay.advance(), gap = label && value ? 2 * overlay.advance() : 0;
  const float column = static_cast<float>(label) * overlay.advance() + gap;
  overlay.fill(x, y, column + static_cast<float>(value) * overlay.advance() + 2 * pad,
               static_cast<float>(lines.size()) * overlay.line_height() + pad, kPanel);
  y += pad / 2;
  for (const Line& line : lines) {
    overlay.text(x + pad, y, line.label, kDim);
    overlay.text(x + pad + column, y, line.value, line.color);
    y += overlay.line_height();
  }
}

std::string title(const ViewControls& controls, const std::string& model) {
  const char* needs = controls.reasons ? "why images are needed" : "where images are needed";
  switch (controls.mode) {
    case ViewMode::kAppearance:
      return model;
    case ViewMode::kHeuristic:
      return needs;
    case ViewMode::kSplit:
      return model + " | " + needs;
    case ViewMode::kCamera:
      return "camera image, tags, pose";
    case ViewMode::kRank:
      return "what the scene required: terms of a patch";
    case ViewMode::kResolution:
      return "what the scene required: samples along a triangle";
    case ViewMode::kBytes:
      return "what the scene required: bytes of a triangle";
  }
  return "";
}

Line tracker_line(TrackerLink link) {
  switch (link) {
    case TrackerLink::kWaiting:
      return {"tracker", "waiting for it", kAmber};
    case TrackerLink::kConnected:
      return {"tracker", "connected", kGreen};
    case TrackerLink::kStale:
      return {"tracker", "STALE: no sign of it", kRed};
    case TrackerLink::kEnded:
      return {"tracker", "the capture has ended", kDim};
    case TrackerLink::kNone:
      break;
  }
  return {"tracker", "none: a saved model", kDim};
}

std::vector<Line> pose_lines(const Capture& capture) {
  if (!capture.pose.usable()) return {{"pose", std::string("none: ") + to_string(capture.pose.status), kRed}};
  if (capture.pose.status == PoseStatus::kGiven) return {{"pose", "given with the image"}};
  return {{"pose", format("%d of %zu tags, error %.2f px", capture.pose.tags_used, capture.tags.size(),
                          capture.pose.reprojection_rms_px)}};
}

std::vector<Line> frame_lines(const CaptureFigures& f) {
  std::uint64_t refused = 0;
  for (const auto& [reason, n] : f.frames_refused) refused += n;
  std::vector<Line> lines{{"frames", format("%llu, used %llu (%llu held out), refused %llu", count(f.frames_received),
                                            count(f.frames_accepted), count(f.frames_held_out), count(refused))}};
  for (const auto& [reason, n] : f.frames_refused)
    lines.push_back({"", format("  %s %llu", reason.c_str(), count(n)), kDim});
  if (f.tracker_judged > 0) {
    std::uint64_t there = 0;
    for (const auto& [reason, n] : f.tracker_refused) there += n;
    lines.push_back({"camera", format("%llu frames, tracker refused %llu", count(f.tracker_judged), count(there))});
    for (const auto& [reason, n] : f.tracker_refused)
      lines.push_back({"", format("  %s %llu", reason.c_str(), count(n)), kDim});
  }
  if (f.frames_withdrawn > 0) lines.push_back({"", format("taken back %llu", count(f.frames_withdrawn))});
  lines.push_back(f.frames_waiting > 0 && f.images_per_s > 0
                      ? Line{"rate",
                             format("%.1f images/s; %llu wait, %.0f s", f.images_per_s, count(f.frames_waiting),
                                    static_cast<double>(f.frames_waiting) / f.images_per_s),
                             kAmber}
                      : Line{"rate", format("%.1f images/s", f.images_per_s)});
  return lines;
}

std::vector<Line> rank_lines(const SnapshotFigures& ranks) {
  return {{"rank", format("median %.3g, most %d", ranks.median_rank, ranks.most_rank)},
          {"surface", format("%.1f %% seen, %.1f %% measured", 100 * ranks.seen, 100 * ranks.measured)}};
}

std::vector<Line> error_lines(const CaptureFigures& f) {
  std::vector<Line> lines;
  if (f.predicted_psnr_db) lines.push_back({"predicted", format("%.1f dB of the last image", *f.predicted_psnr_db)});
  if (f.residual) lines.push_back({"residual", format("%.1f %% of the last image", 100 * *f.residual)});
  if (!f.held_out_psnr_db) return lines;
  std::string value = format("%.1f dB", *f.held_out_psnr_db);
  if (f.held_out_ssim) value += format(", SSIM %.3f", *f.held_out_ssim);
  lines.push_back({"held out", value, kGreen});
  return lines;
}

/// What is traded for what: in green what is kept, in red what is not.
std::vector<Line> trade_lines(const Trade& trade) {
  std::vector<Line> lines;
  const bool full = trade.effort_level == 0 && trade.update_fraction == 1;
  std::string effort = "full";
  if (!full)
    effort = format("level %d of %d, %.0f %% of each image", trade.effort_level, trade.effort_levels - 1,
                    100 * trade.update_fraction);
  if (!trade.favour.empty()) effort += ", favours " + trade.favour;
  lines.push_back({"effort", effort, full ? kDim : kAmber});
  const auto against = [&](const char* label, const std::string& value, const std::optional<bool>& kept) {
    if (kept) lines.push_back({label, value + (*kept ? ", kept" : ", NOT KEPT"), *kept ? kGreen : kRed});
  };
  if (trade.budget_ms)
    against("budget", format("%.1f of %.4g ms per image", trade.image_ms, *trade.budget_ms), trade.budget_kept());
  if (trade.memory_bytes)
    against("memory", format("%.0f of %.4g MB", 1e-6 * trade.grown_bytes, 1e-6 * *trade.memory_bytes),
            trade.memory_kept());
  if (!std::isnan(trade.health.energy_lost))
    lines.push_back({"numerics",
                     format("orthogonal to %.1g, %.2g %% of energy lost", trade.health.orthogonality_lost,
                            100 * trade.health.energy_lost),
                     kDim});
  return lines;
}

}  // namespace

/// Boxes at the bottom stand above the line that says where to go next.
float Hud::bottom_margin(const OverlayPainter& overlay) const {
  if (state.work) return 5.5f * overlay.line_height();
  return guidance ? 3.8f * overlay.line_height() : overlay.advance();
}

void Hud::draw_figures(OverlayPainter& overlay) const {
  std::vector<Line> lines{{"Sheen", title(controls, model)}, tracker_line(state.link)};
  const auto add = [&](const std::vector<Line>& more) { lines.insert(lines.end(), more.begin(), more.end()); };
  if (controls.mode == ViewMode::kCamera) {  // the image is the news: little may cover it
    if (state.capture) add(pose_lines(*state.capture));
  } else {
    if (state.figures) add(frame_lines(*state.figures));
    if (ranks) add(rank_lines(*ranks));
    if (state.figures) add(error_lines(*state.figures));
    if (state.figures) add(trade_lines(state.figures->trade));
    if (controls.follow) add({{"view", "follows the camera"}});
  }
  draw_box(overlay, overlay.advance(), overlay.advance(), lines);
}

void Hud::draw_guidance(OverlayPainter& overlay) const {
  const bool done = state.next_view && state.next_view->well_known;
  if (!guidance) return;
  std::string text = done ? "done" : "next image: " + in_words(*guidance);
  if (state.next_view && !state.next_view->reason.empty())
    text += done ? ": " + state.next_view->reason : " (" + state.next_view->reason + ")";

  const float arrow = 1.4f * overlay.line_height(), pad = overlay.advance();
  const float width = static_cast<float>(text.size()) * overlay.advance() + arrow + 3 * pad;
  const float height = arrow + pad, x = (static_cast<float>(overlay.width()) - width) / 2;
  const float y = static_cast<float>(overlay.height()) - height - 1.2f * overlay.line_height();
  overlay.fill(x, y, width, height, kPanel);
  overlay.text(x + arrow + 2 * pad, y + (height - overlay.line_height()) / 2, text, kText);
  const Eigen::Vector2f middle(x + pad + arrow / 2, y + height / 2);
  if (done || guidance->there()) {
    overlay.fill(middle.x() - arrow / 4, middle.y() - arrow / 4, arrow / 2, arrow / 2, kGreen);
    return;
  }
  const Eigen::Vector2f along =
      Eigen::Vector2d(guidance->right_deg, -guidance->up_deg).normalized().cast<float>() * (arrow / 2);
  const Eigen::Vector2f side(-along.y(), along.x());
  overlay.line(middle - along, middle + 0.2f * along, arrow / 5, kGreen);
  overlay.triangle(middle + along, middle + 0.75f * side, middle - 0.75f * side, kGreen);
}

/// In the place of the guidance: nothing is to be photographed any more.
void Hud::draw_work(OverlayPainter& overlay) const {
  const std::string what = state.work->what;
  const float pad = overlay.advance(), bar = overlay.line_height() / 2;
  const float window = static_cast<float>(overlay.width());
  const float width = std::min(window, std::max(0.5f * window, 60 * overlay.advance() + 2 * pad));
  const float height = 2 * overlay.line_height() + bar + 2 * pad;
  const float x = (static_cast<float>(overlay.width()) - width) / 2;
  float y = static_cast<float>(overlay.height()) - height - 1.2f * overlay.line_height();
  overlay.fill(x, y, width, height, kPanel);
  y += pad / 2;
  overlay.text(x + pad, y, what, kText);
  y += overlay.line_height() + pad / 2;
  overlay.fill(x + pad, y, width - 2 * pad, bar, {70, 75, 84, 255});
  overlay.fill(x + pad, y, (width - 2 * pad) * static_cast<float>(std::clamp(state.work->fraction, 0.0, 1.0)), bar,
               kGreen);
  overlay.text(x + pad, y + bar + pad / 2, state.work->way_out, kDim);
}

/// In the middle of the upper half, in the largest letters that fit.
void Hud::draw_trouble(OverlayPainter& overlay) const {
  if (state.trouble.empty()) return;
  const auto letters = static_cast<float>(state.trouble.size());
  const float window = static_cast<float>(overlay.width());
  const float scale = std::clamp(0.9f * window / ((letters + 2) * overlay.advance()), 1.0f, 3.0f);
  const float width = (letters + 2) * scale * overlay.advance(), height = 1.6f * scale * overlay.line_height();
  const float x = std::max(0.0f, (window - width) / 2), y = 0.28f * static_cast<float>(overlay.height());
  overlay.fill(x, y, width, height, {150, 20, 16, 235});
  overlay.text(x + scale * overlay.advance(), y + 0.3f * scale * overlay.line_height(), state.trouble, kText, scale);
}

void Hud::draw_legend(OverlayPainter& overlay) const {
  struct Swatch {
    Rgba color;
    std::string text;
  };
  std::vector<Swatch> swatches;
  const std::vector<Swatch> states{{rgba(state_color(SampleState::kImputed)), "imputed: few images show it"},
                                   {rgba(state_color(SampleState::kUnseen)), "striped: a guess, no image shows it"}};
  switch (controls.mode) {
    case ViewMode::kHeuristic:
    case ViewMode::kSplit:
      if (controls.reasons) {
        swatches = {{rgba(reason_color(QualityReason::kUnseen)), "no image shows it"},
                    {rgba(reason_color(QualityReason::kOblique)), "seen at grazing angles only"},
                    {rgba(reason_color(QualityReason::kSparseDirections)), "no image from near here"},
                    {rgba(reason_color(QualityReason::kHighResidual)), "images still bring news"},
                    {{43, 43, 43, 255}, "well known"}};
      } else {
        swatches = {{{255, 15, 10, 255}, "needs images: 20 dB expected"},
                    {{149, 29, 27, 255}, "needs some: 26 dB"},
                    {{43, 43, 43, 255}, "well known: no error expected"}};
      }
      if (controls.mode == ViewMode::kSplit && controls.states)
        swatches.insert(swatches.begin(), states.begin(), states.end());
      break;
    case ViewMode::kAppearance:
      if (controls.states)
        swatches = states;
      else if (ranks && ranks->seen > 0 && ranks->seen < 1)
        swatches = {{{52, 55, 62, 255}, "striped: no image shows it"}};
      break;
    case ViewMode::kCamera:
      if (state.capture)
        swatches = {{{60, 230, 90, 255}, "tag used for the pose"},
                    {{255, 150, 40, 255}, "tag left out"},
                    {{64, 217, 255, 255}, "mesh at this pose"}};
      break;
    case ViewMode::kRank:
    case ViewMode::kResolution:
    case ViewMode::kBytes:
      if (!demand || demand->empty()) break;
      for (int stop = kDemandColours - 1; stop >= 0; --stop)
        swatches.push_back(
            {rgba(demand_stop(stop)), format("%.3g%s", demand->most() * static_cast<float>(stop) / (kDemandColours - 1),
                                             stop + 1 == kDemandColours ? " or more" : "")});
      break;
  }
  if (swatches.empty()) return;
  std::size_t longest = 0;
  for (const Swatch& s : swatches) longest = std::max(longest, s.text.size());
  const float pad = overlay.advance(), side = 0.6f * overlay.line_height(), row = overlay.line_height();
  const float width = side + 3 * pad + static_cast<float>(longest) * overlay.advance();
  const float height = static_cast<float>(swatches.size()) * row + pad;
  const float x = static_cast<float>(overlay.width()) - width - pad;
  float y = static_cast<float>(overlay.height()) - height - bottom_margin(overlay);
  overlay.fill(x, y, width, height, kPanel);
  y += pad / 2;
  for (const Swatch& s : swatches) {
    overlay.fill(x + pad, std::round(y + 0.15f * row), side, side, s.color);
    overlay.text(x + side + 2 * pad, y, s.text, kText);
    y += row;
  }
}

void Hud::draw_notes(OverlayPainter& overlay) const {
  const float pad = overlay.advance();
  float y = pad;
  std::vector<std::string> all = notes;
  if (!state.message.empty()) all.push_back(state.message);
  if (state.link == TrackerLink::kStale) all.insert(all.begin(), "no sign of the tracker: the picture is old");
  for (const std::string& note : all) {
    const float width = static_cast<float>(note.size()) * overlay.advance() + 2 * pad;
    const float x = static_cast<float>(overlay.width()) - width - pad;
    overlay.fill(x, y, width, overlay.line_height() + pad / 2, kPanel);
    overlay.text(x + pad, y + pad / 4, note, kAmber);
    y += overlay.line_height() + pad;
  }
}

void Hud::draw_help(OverlayPainter& overlay) const {
  std::vector<Line> lines{{"1", "the object, as the model has it"},
                          {"2", "where images are needed"},
                          {"3", "both, side by side"},
                          {"4", "camera image, tags, pose"},
                          {"5", "what the scene required: terms; again: samples, bytes"},
                          {"W", "why images are needed: by reason"},
                          {"M", "what is measured, imputed, guessed"},
                          {"F", "follow the tracked camera"},
                          {"R", "reset the view"},
                          {"S", "save a screenshot (PNG)"},
                          {"H", "hide these keys"},
                          {"Q, Esc", "quit"},
                          {"drag", "rotate"},
                          {"right drag", "move"},
                          {"Ctrl and drag", "turn the light, where a model knows moving light"},
                          {"wheel", "nearer, farther"}};
  if (state.figures) lines.insert(lines.end() - 5, {"U", "take back the last image"});
  const float height = static_cast<float>(lines.size()) * overlay.line_height() + overlay.advance();
  draw_box(overlay, overlay.advance(), static_cast<float>(overlay.height()) - height - 3.2f * overlay.line_height(),
           lines);
}

void Hud::draw(OverlayPainter& overlay) const {
  draw_figures(overlay);
  if (state.work)
    draw_work(overlay);
  else
    draw_guidance(overlay);
  draw_trouble(overlay);
  draw_legend(overlay);
  draw_notes(overlay);
  if (controls.help)
    draw_help(overlay);
  else
    overlay.text(overlay.advance(), static_cast<float>(overlay.height()) - 1.2f * overlay.line_height(), "H: keys",
                 kDim);
}

}  // namespace sheen
