// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <cstdlib>
#include <exception>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/guarded_thread.h"
#include "common/base/length_limit.h"
#include "common/base/quantity.h"
#include "common/image/image_io.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/render/gl/viewer_window.h"

namespace sheen {
namespace {

struct ViewArguments {
  std::string model, screenshot, mode = "appearance", size = "1280x800";
  std::vector<double> eye;
  bool reasons = false, states = false, clean = false;
};

/// A model on its way into a window: read beside it, and shown as far as it is there.
class Opening {
 public:
  Opening(const ModelKind& kind, const std::filesystem::path& path, ViewerFeed& feed)
      : thread_(guarded_thread([this, &kind, path, &feed] { open(kind, path, feed); },
                               [this](const std::exception_ptr& error) {
                                 error_ = error;
                                 over_ = true;
                                 failure_.request_stop();
                               })) {}

  std::stop_token failed() const { return failure_.get_token(); }
  bool over() const { return over_; }
  /// Rethrows what was wrong with the model.
  void check() {
    if (!failure_.stop_requested()) return;
    thread_.join();
    std::rethrow_exception(error_);
  }

 private:
  void open(const ModelKind& kind, const std::filesystem::path& path, ViewerFeed& feed) {
    constexpr double kFractionOfOneStage = 0.3;  // a bar that moves; nobody knows how long each takes
    ViewerState state;
    state.work = WorkInHand{"The model is being opened", 0, {}};
    feed.publish(state);
    kind.open(path, [&](std::shared_ptr<const ModelSnapshot> model) {
      state.snapshot = std::move(model);
      state.work->fraction += kFractionOfOneStage;
      feed.publish(state);
    });
    state.work.reset();
    feed.publish(std::move(state));
    over_ = true;
  }

  std::exception_ptr error_;
  std::stop_source failure_;
  std::atomic<bool> over_ = false;
  std::jthread thread_;  // last: it uses the others
};

const std::string kModes = "appearance, heuristic, split, camera, rank, resolution, bytes";

/// The model itself, or where `serve` and the demo leave it: in a session, in a folder with a session.
std::filesystem::path model_in(const std::filesystem::path& path) {
  for (const std::filesystem::path& inside : {path / kSessionModel, path / "session" / kSessionModel})
    if (!std::filesystem::exists(path / kModelJsonFile) && std::filesystem::exists(inside)) return inside;
  return path;
}

void view(const ViewArguments& arguments) {
  const auto [width, height] = parse_image_size("--size", arguments.size, 64);
  const std::optional<ViewMode> mode = view_mode_from(arguments.mode);
  if (!mode) throw ConfigError("--mode: '" + arguments.mode + "' is not one of " + kModes);
  const bool picture_only = !arguments.screenshot.empty();
  const std::filesystem::path model = model_in(arguments.model);
  const ModelKind& kind = kind_of_model(model);

  ViewerFeed feed;
  std::optional<Opening> opening;
  if (!picture_only) opening.emplace(kind, model, feed);
  ViewerWindow window(kind, {.width = width, .height = height, .visible = !picture_only});
  ViewControls& controls = window.controls();
  controls.mode = *mode;
  controls.reasons = arguments.reasons;
  controls.states = arguments.states;
  controls.panels = !arguments.clean;
  if (!arguments.eye.empty()) controls.eye = {arguments.eye[0], arguments.eye[1], arguments.eye[2]};

  if (picture_only) {
    ViewerState state;
    state.snapshot = kind.load(model);
    write_png(arguments.screenshot, window.draw_once(state));
    return;
  }
  window.run(feed, opening->failed());
  opening->check();
  if (!opening->over()) std::_Exit(0);  // nothing is lost, and nobody waits for a model that nobody looks at
}

}  // namespace

void add_view_command(Command& program) {
  auto arguments = std::make_shared<ViewArguments>();
  Command command = program.subcommand("view", "Shows a saved model in a window; H lists the keys.");
  command.option("model", arguments->model, "saved model: a file or a folder, or a session with one").required();
  command.option("--screenshot", arguments->screenshot, "PNG to write instead of opening a window");
  command.option("--mode", arguments->mode, kModes).show_default();
  command.flag("--reasons", arguments->reasons, "colour where images are needed by the reason");
  command.flag("--states", arguments->states, "tint what is imputed or unseen");
  command.flag("--clean", arguments->clean, "the object alone, without panels");
  command.option("--size", arguments->size, "size of the window or the screenshot, pixels").show_default();
  command.option("--eye", arguments->eye, "where to look from: x,y,z in the model's frame, metres")
      .check(number_in(-kLongestLength, kLongestLength))
      .delimiter(',')
      .expected(3);
  command.callback([arguments] { view(*arguments); });
}

}  // namespace sheen
