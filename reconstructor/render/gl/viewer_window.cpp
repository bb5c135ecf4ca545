// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/viewer_window.h"

#include <epoxy/gl.h>
// epoxy must come first
#include <GLFW/glfw3.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <string>
#include <utility>

#include "common/base/errors.h"
#include "common/image/image_io.h"
#include "reconstructor/render/gl/lost_display.h"
#include "reconstructor/render/gl/picture_drawer.h"

namespace sheen {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kNewsLasts = std::chrono::seconds(4);
constexpr auto kStill = std::chrono::milliseconds(150);  // after which a hand that does not move has come to rest
constexpr int kRest = 2;  // pause after a frame, in its own durations: drawing in software must leave cores to others
constexpr double kBusySeconds = 0.002;
constexpr double kIdleSeconds = 0.05;  // how long a new state may wait for a window in which nothing moves

std::string glfw_message() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

/// GLFW's library, started and ended with the window.
struct GlfwLibrary {
  GlfwLibrary() {
    if (!glfwInit())
      throw DeviceError("no display for the window (" + glfw_message() +
                        "): start it in a desktop session, under `xvfb-run -a`, or use `sheen-reconstructor render`, "
                        "which needs no display");
    survive_lost_display(display_lost);
  }
  ~GlfwLibrary() { glfwTerminate(); }

  bool display_lost = false;
};

struct WindowDeleter {
  void operator()(GLFWwindow* window) const { glfwDestroyWindow(window); }
};
using WindowHandle = std::unique_ptr<GLFWwindow, WindowDeleter>;

WindowHandle open_window(const ViewerOptions& options) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_VISIBLE, options.visible ? GLFW_TRUE : GLFW_FALSE);
  WindowHandle window(glfwCreateWindow(options.width, options.height, "Sheen", nullptr, nullptr));
  if (!window)
    throw DeviceError("no window with OpenGL 3.3 (" + glfw_message() +
                      "): update the graphics driver, set LIBGL_ALWAYS_SOFTWARE=1 to draw in software, or use "
                      "`sheen-reconstructor render`, which needs no OpenGL");
  glfwMakeContextCurrent(window.get());
  glfwSwapInterval(1);
  return window;
}

std::filesystem::path screenshot_name(ViewMode mode) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
  return std::string("sheen-") + to_string(mode) + "-" + stamp;
}

/// A name that is free: two screenshots a second do not overwrite each other.
std::filesystem::path free_name(const std::filesystem::path& stem) {
  std::filesystem::path path = stem;
  path += ".png";
  for (int i = 2; std::filesystem::exists(path); ++i) {
    path = stem;
    path += "-" + std::to_string(i) + ".png";
  }
  return path;
}

}  // namespace

struct ViewerWindow::Impl {
  Impl(const ModelKind& kind, const ViewerOptions& o)
      : options(o), window(open_window(o)), pictures(kind, o.drawer, o.samples) {
    glfwSetWindowUserPointer(window.get(), this);
    glfwSetKeyCallback(window.get(), [](GLFWwindow* w, int key, int, int action, int) {
      if (action == GLFW_PRESS) of(w).on_key(key);
    });
    glfwSetCursorPosCallback(window.get(), [](GLFWwindow* w, double x, double y) { of(w).on_cursor(x, y); });
    glfwSetScrollCallback(window.get(), [](GLFWwindow* w, double, double steps) {
      of(w).controls.follow = false;
      of(w).controls.orbit.dolly(std::pow(0.9, steps));
      of(w).on_movement();
    });
    glfwSetWindowRefreshCallback(window.get(), [](GLFWwindow* w) { of(w).changed = true; });
    glfwSetFramebufferSizeCallback(window.get(), [](GLFWwindow* w, int, int) { of(w).changed = true; });
  }

  static Impl& of(GLFWwindow* w) { return *static_cast<Impl*>(glfwGetWindowUserPointer(w)); }

  void on_key(int key) {
    changed = true;
    switch (key) {
      case GLFW_KEY_1:
      case GLFW_KEY_2:
      case GLFW_KEY_3:
      case GLFW_KEY_4:
        controls.mode = static_cast<ViewMode>(key - GLFW_KEY_1);
        break;
      case GLFW_KEY_5:  // one after the other
        controls.mode = controls.mode == ViewMode::kRank         ? ViewMode::kResolution
                        : controls.mode == ViewMode::kResolution ? ViewMode::kBytes
                                                                 : ViewMode::kRank;
        break;
      case GLFW_KEY_W:
        controls.reasons = !controls.reasons;
        break;
      case GLFW_KEY_M:
        controls.states = !controls.states;
        break;
      case GLFW_KEY_U:
        if (take_back) tell(take_back());
        break;
      case GLFW_KEY_F:
        controls.follow = !controls.follow;
        break;
      case GLFW_KEY_R:
        controls.reset();
        break;
      case GLFW_KEY_S:
        screenshot_wanted = true;
        break;
      case GLFW_KEY_H:
        controls.help = !controls.help;
        break;
      case GLFW_KEY_Q:
      case GLFW_KEY_ESCAPE:
        glfwSetWindowShouldClose(window.get(), GLFW_TRUE);
        break;
      default:
        break;
    }
  }

  void on_cursor(double x, double y) {
    const Eigen::Vector2d now(x, y), moved = now - cursor;
    cursor = now;
    const auto held = [&](int button) { return glfwGetMouseButton(window.get(), button) == GLFW_PRESS; };
    const bool shift = glfwGetKey(window.get(), GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS;
    int width = 1, height = 1;
    glfwGetWindowSize(window.get(), &width, &height);
    const Eigen::Vector2d part = moved / std::max(1, height);
    const bool control = glfwGetKey(window.get(), GLFW_KEY_LEFT_CONTROL) == GLFW_PRESS;
    if (control && held(GLFW_MOUSE_BUTTON_LEFT)) {
      controls.light_rotation += 4 * Eigen::Vector2d(part.x(), -part.y());
      changed = true;
      return;
    }
    if (held(GLFW_MOUSE_BUTTON_RIGHT) || held(GLFW_MOUSE_BUTTON_MIDDLE) || (held(GLFW_MOUSE_BUTTON_LEFT) && shift))
      controls.orbit.pan(-part.x(), part.y());
    else if (held(GLFW_MOUSE_BUTTON_LEFT))
      controls.orbit.orbit(-4 * part.x(), 4 * part.y());
    else
      return;
    controls.follow = false;
    on_movement();
  }

  void on_movement() {
    moved = Clock::now();
    changed = true;
  }

  std::vector<std::string> current_news() {
    if (!news.empty() && Clock::now() > news_until) news.clear();
    if (news.empty() || screenshot_wanted) return {};  // a screenshot does not show what became of the last one
    return {news};
  }

  void tell(std::string line) {
    news = std::move(line);
    news_until = Clock::now() + kNewsLasts;
    changed = true;
  }

  void save_screenshot() {
    screenshot_wanted = false;
    const auto path = free_name(options.screenshot_folder / screenshot_name(controls.mode));
    try {
      write_png(path, pictures.target().read());
      tell("saved " + path.string());
    } catch (const Error& error) {  // a full disk must not end the capture
      tell(std::string("no screenshot: ") + error.what());
    }
  }

  /// Everything of a state that waits for nobody: a picture without a loop round it.
  void take_in_whole(const ViewerState& state) {
    if (state.snapshot) controls.frame(*state.snapshot);
    while (!pictures.update(state)) {
    }
    pictures.resize(options.width, options.height);
  }

  /// False: there is nothing to draw into.
  bool fit_pictures() {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window.get(), &width, &height);
    if (library.display_lost) return false;     // the size is then any number
    if (width < 1 || height < 1) return false;  // minimised
    pictures.resize(width, height);
    return true;
  }

  /// True: the picture is as fine as can be.
  bool draw_soon(const ViewerState& state) {
    const bool fine = pictures.draw_soon(state, controls, current_news());
    show();
    return fine;
  }
  /// True: the fine picture is there and shown.
  bool draw_piece(const ViewerState& state) {
    const bool fine = pictures.draw_piece(state, controls, current_news());
    if (fine) show();
    return fine;
  }

  void show() {
    pictures.target().show(pictures.target().width(), pictures.target().height());
    glfwSwapBuffers(window.get());
  }

  ViewerOptions options;
  GlfwLibrary library;
  WindowHandle window;
  PictureDrawer pictures;
  ViewControls controls;
  Eigen::Vector2d cursor = Eigen::Vector2d::Zero();
  bool changed = true;      ///< something to draw
  Clock::time_point moved;  ///< when a hand last moved the picture
  bool screenshot_wanted = false;
  std::function<std::string()> take_back;
  std::string news;
  Clock::time_point news_until;
};

ViewerWindow::ViewerWindow(const ModelKind& kind, const ViewerOptions& options)
    : impl_(std::make_unique<Impl>(kind, options)) {}
ViewerWindow::~ViewerWindow() = default;

ViewControls& ViewerWindow::controls() {
  return impl_->controls;
}

void ViewerWindow::run(const ViewerFeed& feed, const std::stop_token& stop, std::function<std::string()> take_back) {
  Impl& w = *impl_;
  w.take_back = std::move(take_back);
  glfwSetWindowShouldClose(w.window.get(), GLFW_FALSE);
  std::shared_ptr<const ViewerState> shown;
  bool complete = true, fine = true;  // all of the state is on the GPU; the picture is as fine as can be
  Clock::time_point rested;           // from when on what nobody asked for may be drawn
  while (!stop.stop_requested() && !glfwWindowShouldClose(w.window.get())) {
    const auto state = feed.latest();
    const bool news_over = !w.news.empty() && Clock::now() > w.news_until;
    const bool stale = !complete || (fine && (state != shown || news_over));
    const auto begun = Clock::now();
    if (w.changed || (stale && begun >= rested)) {
      const bool soon = std::exchange(w.changed, false) || !shown;
      shown = state;
      if (state->snapshot) w.controls.frame(*state->snapshot);
      complete = fine = true;
      if (w.fit_pictures()) {
        complete = w.pictures.update(*state);
        fine = (soon || !complete) && w.draw_soon(*state);
        w.pictures.restart();
        rested = Clock::now() + kRest * (Clock::now() - begun);
      }
    } else if (!fine && complete && begun >= w.moved + kStill) {
      fine = w.draw_piece(*shown);
      rested = std::max(rested, Clock::now()) + kRest * (Clock::now() - begun);
    }
    if (fine && w.screenshot_wanted) w.save_screenshot();
    if (w.changed || (!fine && complete && Clock::now() >= w.moved + kStill))
      glfwPollEvents();
    else
      glfwWaitEventsTimeout(complete && fine ? kIdleSeconds : kBusySeconds);
    if (w.library.display_lost) throw DeviceError("the display has gone away");
  }
}

ImageU8 ViewerWindow::draw_once(const ViewerState& state) {
  Impl& w = *impl_;
  w.take_in_whole(state);
  w.pictures.draw_fine(state, w.controls, w.current_news());
  return w.pictures.target().read();
}

ImageU8 ViewerWindow::draw_soon(const ViewerState& state) {
  Impl& w = *impl_;
  w.take_in_whole(state);
  w.pictures.draw_soon(state, w.controls, w.current_news());
  return w.pictures.target().read();
}

const FramePacer& ViewerWindow::pacer() const {
  return impl_->pictures.pacer();
}

}  // namespace sheen
