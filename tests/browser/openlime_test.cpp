// SPDX-License-Identifier: Apache-2.0
// What `export` writes for the web, in OpenLIME in a real browser. $SHEEN_OPENLIME names the folder of its
// openlime.umd.js (npm: openlime, dist/js).
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <thread>

#include "common/base/files.h"
#include "common/image/image_io.h"
#include "common/image/linear_reader.h"
#include "reconstructor/exchange/polynomial_texture.h"
#include "tests/support/temp_folder.h"

// Last: it brings macros that Eigen's headers cannot bear.
#include <httplib.h>

namespace sheen {
namespace {

namespace fs = std::filesystem;

/// A picture that is red where light comes from the right and blue where it comes from the left; green above the
/// middle.
PolynomialTexture coloured() {
  PolynomialTexture texture;
  for (ImageF& plane : texture.planes) plane = ImageF(200, 100, 3);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 200; ++x) {
      texture.planes[0].at(x, y, 0) = 0.5f;
      texture.planes[0].at(x, y, 1) = y < 50 ? 0.8f : 0.1f;
      texture.planes[0].at(x, y, 2) = 0.5f;
      texture.planes[1].at(x, y, 0) = 0.5f;
      texture.planes[1].at(x, y, 2) = -0.5f;
    }
  return texture;
}

class Served {
 public:
  explicit Served(const fs::path& folder) {
    server_.set_mount_point("/", folder.string());
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
  }
  ~Served() {
    server_.stop();
    thread_.join();
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/"; }

 private:
  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
};

/// What a page shows, sRGB values 0..1.
ImageF screenshot(const std::string& url, const fs::path& folder) {
  const fs::path file = folder / "shot.png";
  const std::string command =
      "timeout 100 chromium --headless --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage "
      "--hide-scrollbars --window-size=400,200 --virtual-time-budget=8000 --user-data-dir='" +
      (folder / "profile").string() + "' --screenshot='" + file.string() + "' '" + url + "' > /dev/null 2>&1";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("the browser failed");
  return to_linear_rgb(read_image(file));
}

TEST(OpenLime, ShowsAnExportedFolder) {
  const char* openlime = std::getenv("SHEEN_OPENLIME");
  if (std::system("command -v chromium > /dev/null 2>&1") != 0) GTEST_SKIP() << "chromium is not installed";
  if (!openlime || !fs::exists(fs::path(openlime) / "openlime.umd.js"))
    GTEST_SKIP() << "$SHEEN_OPENLIME does not name the folder of OpenLIME's openlime.umd.js";
  const TempFolder folder;
  const fs::path page = folder.path() / "page";
  write_relight(page, coloured());
  write_file(page / "openlime.umd.js", read_file(fs::path(openlime) / "openlime.umd.js"));
  const auto light_from = [&](const std::string& name, double x) {
    std::string text = read_file(page / "index.html");
    const std::string place = "viewer.addLayer('object', layer);";
    const std::size_t at = text.find(place);
    EXPECT_NE(at, std::string::npos);
    text.insert(at + place.size(), "layer.addEvent('ready', () => layer.setLight([" + std::to_string(x) + ", 0], 0));");
    write_file(page / name, text);
    return name;
  };
  const Served served(page);
  for (const double x : {0.6, -0.6}) {
    const ImageF shown = screenshot(served.url() + light_from("lit.html", x), folder.path());
    const float *above = shown.pixel(200, 60), *below = shown.pixel(200, 140);
    const auto linear = [](double encoded) { return std::pow((encoded + 0.055) / 1.055, 2.4); };
    EXPECT_NEAR(above[0], linear(0.5 + 0.5 * x), 0.05) << x;
    EXPECT_NEAR(above[2], linear(0.5 - 0.5 * x), 0.05) << x;
    EXPECT_GT(above[1], 0.5) << x;
    EXPECT_LT(below[1], 0.05) << x;
  }
}

}  // namespace
}  // namespace sheen
