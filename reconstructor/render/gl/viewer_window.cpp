// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/viewer_window.h"

#include <epoxy/gl.h>
// epoxy must come first
#include <GLFW/glfw3.h>

#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "common/base/errors.h"
#include "common/image/image_io.h"
#include "reconstructor/render/gl/hand.h"
#include "reconstructor/render/gl/lost_display.h"
#include "reconstructor/render/gl/panels.h"
#include "reconstructor/render/gl/picture_drawer.h"
#include "reconstructor/render/gl/screenshot_file.h"
#include "reconstructor/render/gl/view_action.h"

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

}  // namespace

struct ViewerWindow::Impl {
  Impl(const ModelKind& kind, const ViewerOptions& o)
      : options(o), window(open_window(o)), pictures(kind, o.drawer, o.samples) {
    hand.holds_light(!pictures.scene().follows_eye());
    glfwSetWindowUserPointer(window.get(), this);
    glfwSetKeyCallback(window.get(), [](GLFWwindow* w, int key, int, int action, int modifiers) {
      if (action != GLFW_RELEASE) of(w).on_key(key, modifiers, action == GLFW_PRESS);
    });
    glfwSetMouseButtonCallback(window.get(), [](GLFWwindow* w, int button, int action, int) {
      of(w).on_button(button, action == GLFW_PRESS);
    });
    glfwSetCursorPosCallback(window.get(), [](GLFWwindow* w, double x, double y) { of(w).on_cursor(x, y); });
    glfwSetScrollCallback(window.get(), [](GLFWwindow* w, double, double steps) { of(w).on_wheel(steps); });
    glfwSetWindowRefreshCallback(window.get(), [](GLFWwindow* w) { of(w).changed = true; });
    glfwSetFramebufferSizeCallback(window.get(), [](GLFWwindow* w, int, int) { of(w).changed = true; });
  }

  static Impl& of(GLFWwindow* w) { return *static_cast<Impl*>(glfwGetWindowUserPointer(w)); }

  void on_key(int key, int modifiers, bool first) {
    if (on_moving_key(key, {(modifiers & GLFW_MOD_SHIFT) != 0, (modifiers & GLFW_MOD_CONTROL) != 0}) || !first) return;
    if (key == GLFW_KEY_ESCAPE) return perform(ViewAction::kQuit);
    if (const std::optional<ViewAction> action = action_of_key(key)) perform(*action);
  }

  /// Arrows, plus and minus do what the mouse does.
  bool on_moving_key(int key, Hand::Modifiers modifiers) {
    switch (key) {
      case GLFW_KEY_LEFT:
        return moves(hand.arrow(-1, 0, modifiers));
      case GLFW_KEY_RIGHT:
        return moves(hand.arrow(1, 0, modifiers));
      case GLFW_KEY_UP:
        return moves(hand.arrow(0, -1, modifiers));
      case GLFW_KEY_DOWN:
        return moves(hand.arrow(0, 1, modifiers));
      case GLFW_KEY_EQUAL:  // where plus is
      case GLFW_KEY_KP_ADD:
        return moves(hand.come_nearer(1));
      case GLFW_KEY_MINUS:
      case GLFW_KEY_KP_SUBTRACT:
        return moves(hand.come_nearer(-1));
      default:
        return false;
    }
  }

  void perform(ViewAction action) {
    changed = true;
    if (apply(action, controls)) return;
    if (action == ViewAction::kUndo && requests.take_back) tell(requests.take_back());
    if (action == ViewAction::kHoldOut && requests.hold_out) tell(requests.hold_out());
    if (action == ViewAction::kScreenshot) screenshot_wanted = true;
    if (action == ViewAction::kQuit) glfwSetWindowShouldClose(window.get(), GLFW_TRUE);
  }

  std::vector<ViewAction> offered(const ViewerState& state) const {
    std::vector<ViewAction> actions;
    const bool live = state.capture || state.link != TrackerLink::kNone;
    for (const ActionWords& words : view_actions()) {
      const ViewAction action = words.action;
      if ((action == ViewAction::kCamera || action == ViewAction::kFollow) && !live) continue;
      if (action == ViewAction::kShape && !(state.snapshot && !state.snapshot->mesh().evidence.empty())) continue;
      if (action == ViewAction::kUndo && !requests.take_back) continue;
      if (action == ViewAction::kHoldOut && !requests.hold_out) continue;
      actions.push_back(action);
    }
    return actions;
  }

  bool on_panel() const { return panels.cover(hand.pointer().at); }

  void on_button(int which, bool pressed) {
    const Hand::Button button = which == GLFW_MOUSE_BUTTON_LEFT ? Hand::Button::kLeft : Hand::Button::kOther;
    if (pressed)
      hand.press(button, on_panel());
    else
      hand.release(button);
    panels_changed = true;
  }

  void on_wheel(double steps) {
    panels_changed |= on_panel();
    moves(hand.wheel(steps, on_panel()));
  }

  void on_cursor(double x, double y) {
    int width = 1, height = 1, pixels_across = 1, pixels_down = 1;
    glfwGetWindowSize(window.get(), &width, &height);
    glfwGetFramebufferSize(window.get(), &pixels_across, &pixels_down);
    const auto down = [&](int left, int right) {
      return glfwGetKey(window.get(), left) == GLFW_PRESS || glfwGetKey(window.get(), right) == GLFW_PRESS;
    };
    const bool was_on_panel = on_panel();
    const Eigen::Vector2d place(x * pixels_across / std::max(1, width), y * pixels_down / std::max(1, height));
    moves(hand.point(
        place.cast<float>(), pixels_down,
        {down(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT), down(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL)}));
    panels_changed |= was_on_panel || hand.pointer().pressed || on_panel();
  }

  /// True for callers that have done what they were asked for.
  bool moves(bool picture_moved) {
    if (picture_moved) on_movement();
    return true;
  }

  void on_movement() {
    moved = Clock::now();
    changed = true;
  }

  std::vector<std::string> current_news() {
    if (!news.empty() && Clock::now() > news_until) news.clear();
    if (news.empty()) return {};
    return {news};
  }

  void tell(std::string line) {
    news = std::move(line);
    news_until = Clock::now() + kNewsLasts;
    changed = true;
  }

  /// Pixels for what is one on a screen of ordinary density; more in a window that is large without being dense.
  float panel_scale() const {
    constexpr float kTallest = 1400;
    float across = 1, down = 1;
    glfwGetWindowContentScale(window.get(), &across, &down);
    return std::max({1.0f, across, static_cast<float>(pictures.target().height()) / kTallest});
  }

  /// Into the framebuffer that is bound.
  PanelEvents draw_panels(const ViewerState& state, const ViewControls& chosen) {
    const int width = pictures.target().width(), height = pictures.target().height();
    const Told told = pictures.scene().told(state, chosen, current_news(), width, height);
    const std::vector<Sketch> sketches = ViewerScene::sketches(state, chosen, width, height);
    PanelEvents events =
        panels.lay_out({state, chosen, told, sketches, offered(state)}, width, height, panel_scale(), hand.pointer());
    panels_changed |= hand.looked_at();
    panels.draw();
    return events;
  }

  ImageU8 picture_with_panels(const ViewerState& state, const ViewControls& chosen) {
    pictures.target().draw_over();
    draw_panels(state, chosen);
    return pictures.target().read();
  }

  /// Of the object alone.
  void save_screenshot(const ViewerState& state) {
    screenshot_wanted = false;
    changed = true;  // what belongs to the picture is drawn over it
    ViewControls clean = controls;
    clean.panels = false;
    const auto path = free_screenshot(options.screenshot_folder, controls.mode);
    try {
      write_png(path, picture_with_panels(state, clean));
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
    const bool fine = pictures.draw_soon(state, controls);
    show(state);
    return fine;
  }
  /// True: the fine picture is there and shown.
  bool draw_piece(const ViewerState& state) {
    const bool fine = pictures.draw_piece(state, controls);
    if (fine) show(state);
    return fine;
  }

  void show(const ViewerState& state) {
    panels_changed = false;
    pictures.target().show(pictures.target().width(), pictures.target().height());
    const PanelEvents events = draw_panels(state, controls);
    glfwSwapBuffers(window.get());
    for (const ViewAction action : events.pressed) perform(action);
    if (events.light && !controls.light.isApprox(*events.light, 1e-6)) {
      controls.light = *events.light;
      on_movement();
    }
  }

  ViewerOptions options;
  GlfwLibrary library;
  WindowHandle window;
  PictureDrawer pictures;
  Panels panels;
  ViewControls controls;
  Hand hand{controls};
  bool changed = true;          ///< something to draw
  bool panels_changed = false;  ///< the picture is as it was
  Clock::time_point moved;      ///< when a hand last moved the picture
  bool screenshot_wanted = false;
  CaptureRequests requests;
  std::string news;
  Clock::time_point news_until;
};

ViewerWindow::ViewerWindow(const ModelKind& kind, const ViewerOptions& options)
    : impl_(std::make_unique<Impl>(kind, options)) {}
ViewerWindow::~ViewerWindow() = default;

ViewControls& ViewerWindow::controls() {
  return impl_->controls;
}

void ViewerWindow::run(const ViewerFeed& feed, const std::stop_token& stop, CaptureRequests requests) {
  Impl& w = *impl_;
  w.requests = std::move(requests);
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
    if (w.panels_changed && !w.changed && shown) w.show(*shown);
    if (fine && w.screenshot_wanted) w.save_screenshot(*shown);
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
  w.pictures.draw_fine(state, w.controls);
  return w.picture_with_panels(state, w.controls);
}

ImageU8 ViewerWindow::draw_soon(const ViewerState& state) {
  Impl& w = *impl_;
  w.take_in_whole(state);
  w.pictures.draw_soon(state, w.controls);
  return w.picture_with_panels(state, w.controls);
}

const FramePacer& ViewerWindow::pacer() const {
  return impl_->pictures.pacer();
}

}  // namespace sheen
