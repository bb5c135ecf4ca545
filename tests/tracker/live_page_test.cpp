// SPDX-License-Identifier: Apache-2.0
#include "tracker/live_page/live_page.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/image_io.h"
#include "tests/support/temp_folder.h"
#include "tracker/preview.h"

// Last: it brings macros that Eigen's headers cannot bear.
#include <httplib.h>

namespace sheen {
namespace {

/// A ramp from left to right, brighter in the middle of the picture.
RawImage ramp(int width, int height) {
  RawImage image{.format = PixelFormat::kMono8,
                 .transfer = Transfer::kSrgb,
                 .width = width,
                 .height = height,
                 .stride = static_cast<std::size_t>(width),
                 .bytes = {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.bytes.push_back(static_cast<std::uint8_t>(40 + 160 * x / width));
  return image;
}

class LivePageTest : public ::testing::Test {
 protected:
  httplib::Result get(const std::string& path, const std::string& host = "localhost") {
    return client().Get(path, {{"Host", host}});
  }
  httplib::Client client() { return httplib::Client(page_.url().substr(0, page_.url().size() - 1)); }
  nlohmann::json look() { return nlohmann::json::parse(get("/look.json")->body); }
  /// Shows the image until the page has taken one more.
  void show_one(const RawImage& image, const LiveWords& words) {
    const int before = look().value("number", 0);
    for (int tries = 0; tries < 200 && look().value("number", 0) == before; ++tries) {
      page_.show(image, words);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  ImageU8 picture(const std::string& path) {
    const auto answer = get(path);
    EXPECT_EQ(answer->get_header_value("Content-Type"), "image/jpeg");
    return viewable(read_image(temp_.write("shown.jpg", answer->body)));
  }

  LivePage page_{0};
  TempFolder temp_;
};

TEST_F(LivePageTest, ShowsThePictureItsMiddleAndTheWords) {
  page_.show(ramp(2000, 500), {.first = "nobody looks yet"});
  EXPECT_EQ(look(), nlohmann::json::object());
  EXPECT_EQ(get("/picture.jpg")->status, 404);
  show_one(ramp(2000, 500), {.first = "too dark", .detail = "frame 7", .focus = 0.2, .best_focus = 0.25});
  const nlohmann::json seen = look();
  EXPECT_EQ(seen["first"], "too dark");
  EXPECT_EQ(seen["well"], false);
  EXPECT_EQ(seen["detail"], "frame 7");
  EXPECT_EQ(seen["focus"], 0.2);
  EXPECT_EQ(seen["width"], 2000);
  const ImageU8 whole = picture("/picture.jpg"), middle = picture("/middle.jpg");
  EXPECT_EQ(whole.width(), 666);
  EXPECT_EQ(whole.height(), 166);
  EXPECT_NEAR(whole.at(333, 80, 0), 120, 4);
  EXPECT_EQ(middle.width(), 320);
  EXPECT_EQ(middle.height(), 320);
  EXPECT_NEAR(middle.at(0, 100, 0), 40 + 160 * 840 / 2000, 4);

  show_one(ramp(64, 48), {.first = "Nothing is wrong.", .well = true});
  EXPECT_EQ(look()["number"], 2);
  EXPECT_TRUE(look()["focus"].is_null());
  EXPECT_EQ(picture("/picture.jpg").width(), 64);
  EXPECT_EQ(picture("/middle.jpg").height(), 48);
}

TEST_F(LivePageTest, OtherWordsLeaveThePicture) {
  page_.say({.first = "nothing was shown yet"});
  EXPECT_EQ(get("/look.json")->body, "{}");
  show_one(ramp(400, 300), {.first = "turn the lens"});
  const std::string shown = get("/picture.jpg")->body;
  page_.say({.first = "the camera is gone"});
  EXPECT_EQ(look()["first"], "the camera is gone");
  EXPECT_EQ(look()["width"], 400);
  EXPECT_EQ(get("/picture.jpg")->body, shown);
}

TEST_F(LivePageTest, IsOnePageForThisMachineAlone) {
  EXPECT_EQ(get("/")->get_header_value("Content-Type"), "text/html; charset=utf-8");
  EXPECT_NE(get("/")->body.find("look.json"), std::string::npos);
  EXPECT_EQ(get("/", "127.0.0.1:7481")->status, 200);
  for (const char* host : {"attacker.example", "localhost.attacker.example", "", "10.0.0.1:7481"})
    EXPECT_EQ(get("/look.json", host)->status, 403) << host;
  EXPECT_EQ(get("/secret")->status, 404);
  EXPECT_EQ(client().Post("/", "x", "text/plain")->status, 405);
}

TEST_F(LivePageTest, APortInUseIsNamed) {
  const int port = std::stoi(page_.url().substr(page_.url().rfind(':') + 1));
  try {
    const LivePage second(port);
    FAIL() << "two pages at one port";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find(std::to_string(port)), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace sheen
