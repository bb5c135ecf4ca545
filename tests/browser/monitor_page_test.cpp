// SPDX-License-Identifier: Apache-2.0
// The monitor page in a real browser.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stop_token>
#include <thread>

#include "common/image/image_io.h"
#include "common/image/linear_reader.h"
#include "reconstructor/monitor/monitor_server.h"
#include "tests/reconstructor/monitor/sample_state.h"

namespace sheen {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

bool browser_installed() {
  return std::system("command -v chromium > /dev/null 2>&1") == 0;
}

std::string jpeg_of(std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  ImageU8 image(320, 240, 3);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const bool in = (x - 160) * (x - 160) + (y - 120) * (y - 120) < 90 * 90;
      image.at(x, y, 0) = in ? red : 20;
      image.at(x, y, 1) = in ? green : 20;
      image.at(x, y, 2) = in ? blue : 20;
    }
  const std::vector<std::uint8_t> bytes = encode_jpeg(image, 90);
  return std::string(bytes.begin(), bytes.end());
}

/// Runs the browser on a page until its script has had three seconds; standard output.
std::string browse(const std::string& arguments) {
  std::string profile = (std::filesystem::path(testing::TempDir()) / "sheen_browser_XXXXXX").string();
  if (::mkdtemp(profile.data()) == nullptr) throw std::runtime_error("no folder for the browser's profile");
  const std::string command =
      "timeout 40 chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking "
      "--disable-component-update --disable-sync --disable-dev-shm-usage --hide-scrollbars --virtual-time-budget=3000 "
      "--user-data-dir='" +
      profile + "' " + arguments + " 2> /dev/null";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  std::string output;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) output.append(buffer.data(), n);
  ::pclose(pipe);
  std::filesystem::remove_all(profile);
  return output;
}

/// Publishes a state again and again, as a reconstructor does: a browser may take longer to start than the few seconds
/// after which a reconstructor that says nothing is called stalled.
class Publisher {
 public:
  Publisher(MonitorServer& server, const MonitorState& state) {
    server.publish(state);
    thread_ = std::jthread([&server, state](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        server.publish(state);
      }
    });
  }

 private:
  std::jthread thread_;
};

std::string element(const std::string& id, const std::string& text) {
  return "id=\"" + id + "\">" + text + "<";
}

/// Pixels of the curve's colour in a screenshot of the light scheme.
int accent_pixels(const std::filesystem::path& screenshot) {
  const ImageF linear = to_linear_rgb(read_image(screenshot));
  int n = 0;
  for (int y = 0; y < linear.height(); ++y)
    for (int x = 0; x < linear.width(); ++x) {
      const float r = linear.at(x, y, 0), g = linear.at(x, y, 1), b = linear.at(x, y, 2);
      n += r < 0.02F && g > 0.15F && g < 0.25F && b > 0.2F && b < 0.3F;
    }
  return n;
}

class MonitorPage : public testing::Test {
 protected:
  void SetUp() override {
    if (!browser_installed()) GTEST_SKIP() << "chromium is not installed";
  }
};

TEST_F(MonitorPage, ShowsWhatWasPublished) {
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.preview_jpeg = std::make_shared<const std::string>(jpeg_of(200, 120, 60));
  state.links.push_back({"viewer", "tcp://192.0.2.7:7411", false, true, "refused: unknown key", true});
  const Publisher publisher(server, state);

  const std::string page = browse("--dump-dom " + server.url());
  EXPECT_THAT(page, HasSubstr("data-state=\"disconnected\""));
  EXPECT_THAT(page, HasSubstr(element("state-detail", "viewer is gone")));
  EXPECT_THAT(page, HasSubstr("The connection is lost: viewer is gone."));
  EXPECT_THAT(page, HasSubstr("data-tone=\"bad\""));
  EXPECT_THAT(page, HasSubstr(element("session", "/captures/teapot")));
  EXPECT_THAT(page, HasSubstr(element("accepted", "121")));
  EXPECT_THAT(page, HasSubstr(element("accepted-detail", "160 received, 26 refused, 6 waiting")));
  EXPECT_THAT(page, HasSubstr(element("psnr", "34.31")));
  EXPECT_THAT(page, HasSubstr(element("psnr-detail", "+5.44 dB over constant colour")));
  EXPECT_THAT(page, HasSubstr(element("ssim", "0.9612")));
  EXPECT_THAT(page, HasSubstr(element("preview-note", "no photograph from here: the nearest is 34 degrees away")));
  EXPECT_THAT(page, HasSubstr(element("next-view", "Next: move the camera to the left of the object, lower")));
  EXPECT_THAT(page, AllOf(HasSubstr("object not in view"), HasSubstr("31 of 64"), HasSubstr("rank 3"),
                          HasSubstr("tcp://127.0.0.1:7410"), HasSubstr("refused: unknown key")));
  EXPECT_THAT(page, HasSubstr("src=\"preview.jpg?v=1\""));
  EXPECT_THAT(page, HasSubstr("id=\"camera\" alt=\"The newest camera image\" hidden"));
}

TEST_F(MonitorPage, OneSentenceComesFirst) {
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.tracker.trouble.clear();
  const auto shown = [&] {
    state.last_frame = MonitorState::Clock::now() + std::chrono::minutes(1);  // a browser may take long to start
    const Publisher publisher(server, state);
    return browse("--dump-dom " + server.url());
  };
  EXPECT_THAT(shown(),
              AllOf(HasSubstr("role=\"status\">82 % of the surface is seen.<"), HasSubstr("data-tone=\"good\""),
                    HasSubstr("121 images in the model · 34.3 dB on views it never saw")));
  state.tracker.trouble = "too fast: motion blur";
  EXPECT_THAT(shown(), AllOf(HasSubstr("The latest images cannot be used."), HasSubstr("data-tone=\"bad\"")));
}

TEST_F(MonitorPage, ButtonsAreForWhoMaySteer) {
  MonitorServer server({.port = 0, .steer_token = "fedcba9876543210", .steer = [](const SteerRequest&) { return ""; }});
  const Publisher publisher(server, sample_monitor_state());
  EXPECT_THAT(browse("--dump-dom " + server.url()),
              HasSubstr("<section id=\"steering\" aria-label=\"Steering\" hidden"));
  EXPECT_THAT(browse("--dump-dom '" + server.url() + "?token=fedcba9876543210'"),
              HasSubstr("<section id=\"steering\" aria-label=\"Steering\">"));
}

TEST_F(MonitorPage, BeforeTheFirstTrackerSaysHowToStartOne) {
  MonitorServer server({.port = 0});
  MonitorState state;
  state.links = {{.name = "tracker", .endpoint = "tcp://127.0.0.1:7410"}};
  state.hint = "sheen-tracker run --config rig.toml";
  const Publisher publisher(server, state);
  const std::string page = browse("--dump-dom " + server.url());
  EXPECT_THAT(page, HasSubstr("data-state=\"waiting\""));
  EXPECT_THAT(page, HasSubstr(element("state-detail", "for a tracker")));
  EXPECT_THAT(page, HasSubstr("<p id=\"hint\">Start a tracker: <code>sheen-tracker run --config rig.toml</code>"));
  EXPECT_THAT(page, HasSubstr("<li class=\"\">")) << "not red";
  EXPECT_THAT(page, HasSubstr("<span>not there yet</span>"));
}

TEST_F(MonitorPage, WhileAShapeIsLookedForItSaysSoAndShowsTheCamera) {
  MonitorServer server({.port = 0});
  MonitorState state;
  state.links = {{.name = "tracker", .endpoint = "tcp://127.0.0.1:7410", .connected = true, .came = true}};
  state.doing = "The shape is being found in 9 images.";
  state.camera_jpeg = std::make_shared<const std::string>(jpeg_of(200, 120, 60));
  const Publisher publisher(server, state);
  EXPECT_THAT(
      browse("--dump-dom " + server.url()),
      AllOf(HasSubstr("role=\"status\">The shape is being found in 9 images.<"), HasSubstr("data-tone=\"busy\""),
            HasSubstr("src=\"camera.jpg?v=1\""), HasSubstr("<figure id=\"shape-figure\" hidden")));
}

TEST_F(MonitorPage, ShowsAFoundShapeAndFromWhatItIsKnown) {
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.shape_jpeg = std::make_shared<const std::string>(jpeg_of(46, 168, 97));
  {
    const Publisher publisher(server, state);
    EXPECT_THAT(browse("--dump-dom " + server.url()),
                AllOf(HasSubstr("<figure id=\"shape-figure\">"), HasSubstr("src=\"shape.jpg?v=1\""),
                      HasSubstr("images agree <b>81 %</b>"), HasSubstr("outlines <b>5 %</b>"),
                      HasSubstr("a guess <b>14 %</b>")));
  }
  state.shape.reset();  // a mesh was given
  const Publisher publisher(server, state);
  EXPECT_THAT(browse("--dump-dom " + server.url()), HasSubstr("<figure id=\"shape-figure\" hidden"));
}

TEST_F(MonitorPage, ShowsHowFarTheEndIs) {
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.ending = {CaptureState::kSaving, 13, 52};
  const Publisher publisher(server, state);
  const std::string page = browse("--dump-dom " + server.url());
  EXPECT_THAT(page, HasSubstr("data-state=\"saving\""));
  EXPECT_THAT(page, HasSubstr(element("state-detail", "the model: part 13 of 52")));
  EXPECT_THAT(page, AllOf(HasSubstr("aria-valuenow=\"25\""), HasSubstr("<div style=\"width: 25%;\">"),
                          HasSubstr("The model is being saved.")));
}

TEST_F(MonitorPage, SaysWhenAllIsWellKnown) {
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.well_known = true;
  state.next_view = "even from the least known place 36 dB are expected";
  const Publisher publisher(server, state);
  EXPECT_THAT(browse("--dump-dom " + server.url()),
              HasSubstr("id=\"next-view\" class=\"done\">Done: even from the least known place 36 dB are expected<"));
}

TEST_F(MonitorPage, TextFromElsewhereStaysText) {
  MonitorServer server({.port = 0, .token = "0123456789abcdef"});
  MonitorState state = sample_monitor_state();
  state.refused = {{"<img src=x onerror=\"document.title='taken'\">", 4}};
  state.links[0].last_error = "<script>document.title='taken'</script>";
  const Publisher publisher(server, state);
  const std::string page = browse("--dump-dom '" + server.url() + "?token=0123456789abcdef'");
  EXPECT_THAT(page, HasSubstr("&lt;img src=x"));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;document.title"));
  EXPECT_THAT(page, Not(HasSubstr("<title>taken")));
  EXPECT_THAT(page, HasSubstr("href=\"status.json?token=0123456789abcdef\""));
}

TEST_F(MonitorPage, SaysWhenItsTokenIsWrongOrNobodyIsThere) {
  std::string url;
  {
    const MonitorServer server({.port = 0});
    url = server.url();
  }
  const MonitorServer server({.port = 0, .token = "0123456789abcdef"});
  EXPECT_THAT(browse("--dump-dom " + server.url()), HasSubstr("A token is needed"));
  EXPECT_THAT(browse("--dump-dom " + url), Not(HasSubstr("data-state=\"live\"")));
}

TEST_F(MonitorPage, DrawsTheCurve) {
  const std::filesystem::path folder = testing::TempDir();
  MonitorServer server({.port = 0});
  MonitorState state = sample_monitor_state();
  state.preview_jpeg = std::make_shared<const std::string>(jpeg_of(200, 120, 60));
  state.camera_jpeg = std::make_shared<const std::string>(jpeg_of(180, 130, 80));
  const auto screenshot = [&](const std::string& name) {
    const Publisher publisher(server, state);
    const std::filesystem::path file = folder / name;
    browse("--window-size=1280,2400 --screenshot='" + file.string() + "' " + server.url() + "#details");
    return accent_pixels(file);
  };
  const int with_curve = screenshot("sheen_monitor_page.png");
  state.held_out_curve.resize(1);  // a point is no line
  EXPECT_GT(with_curve, screenshot("sheen_monitor_page_without_curve.png") + 1000);
}

}  // namespace
}  // namespace sheen
