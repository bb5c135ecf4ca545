// SPDX-License-Identifier: Apache-2.0
// The page that `export` writes, in a real browser: its pictures against those of the ray painter.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/files.h"
#include "common/image/color.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/export_page.h"
#include "reconstructor/render/gl/orbit_camera.h"
#include "reconstructor/render/outlines.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/support/process.h"
#include "tests/support/temp_folder.h"

// Last: it brings macros that Eigen's headers cannot bear.
#include <httplib.h>

namespace sheen {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kWidth = 480, kHeight = 360;
constexpr double kTanHalfView = 0.36397023426620234;  // tan 20 degrees, of the shorter side

struct Eye {
  Eigen::Vector3d place, target, up;
};

/// Shows the page in a frame, asks it for a picture from each eye, or in each light, and posts them.
const char* const kAsking =
    R"html(<!doctype html><iframe src="page/index.html" width="480" height="360" style="border:0"></iframe>
<script>
const post = (path, body) => fetch(path, { method: "POST", body });
(async () => {
  const { eyes, lights, lose } = await (await fetch("eyes.json")).json(), frame = document.querySelector("iframe");
  const state = () => frame.contentWindow.sheen?.figures().state;
  while (state() !== "whole" && state() !== "failed") await new Promise((go) => setTimeout(go, 20));
  const { sheen } = frame.contentWindow;
  for (const { eye, target, up } of state() === "whole" ? eyes : []) {
    const { pixels } = await sheen.lookFrom(eye, target, up, { markGuesses: false });
    await post("picture", pixels);
    if (!lose) continue;
    const canvas = frame.contentDocument.getElementById("view");
    const graphics = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
    graphics.loseContext();
    await new Promise((go) => setTimeout(go, 100));
    const restored = new Promise((go) => canvas.addEventListener("webglcontextrestored", () => setTimeout(go)));
    graphics.restoreContext();
    await restored;
    await post("picture", (await sheen.lookFrom(eye, target, up, { markGuesses: false })).pixels);
  }
  for (const light of lights) {
    const { width, height, pixels } = await sheen.lightFrom(light);
    await post(`lit?width=${width}&height=${height}`, pixels);
  }
  await post("done", JSON.stringify({ ...sheen.figures(),
                                      failure: frame.contentDocument.getElementById("failure").textContent }));
})().catch((error) => post("done", JSON.stringify({ failure: String(error) })));
</script>)html";

/// What the page showed.
struct Shown {
  std::vector<ImageU8> pictures;  ///< RGBA
  Json figures;
};

std::vector<double> numbers(const Eigen::Vector3d& v) {
  return {v.begin(), v.end()};
}

/// A folder, served to a browser, whose page is asked for pictures, as `asked` says.
Shown shown_in_browser(const fs::path& folder, const Json& asked) {
  write_file(folder / "eyes.json", asked.dump());
  write_file(folder / "ask.html", kAsking);

  Shown shown;
  std::promise<std::string> done;
  httplib::Server server;
  server.set_mount_point("/", folder.string());
  server.Post("/picture", [&](const httplib::Request& request, httplib::Response&) {
    ImageU8 picture(kWidth, kHeight, 4);
    if (request.body.size() != picture.size()) return;
    for (int y = 0; y < kHeight; ++y)  // its bottom row is the first
      std::copy_n(request.body.data() + std::size_t(kHeight - 1 - y) * kWidth * 4, std::size_t(kWidth) * 4,
                  reinterpret_cast<char*>(picture.row(y)));
    shown.pictures.push_back(std::move(picture));
  });
  server.Post("/lit", [&](const httplib::Request& request, httplib::Response&) {
    ImageU8 picture(std::stoi(request.get_param_value("width")), std::stoi(request.get_param_value("height")), 4);
    if (request.body.size() != picture.size()) return;
    std::copy_n(request.body.data(), picture.size(), reinterpret_cast<char*>(picture.data()));
    shown.pictures.push_back(std::move(picture));
  });
  server.Post("/done", [&](const httplib::Request& request, httplib::Response&) { done.set_value(request.body); });
  const int port = server.bind_to_any_port("127.0.0.1");
  std::thread serving([&] { server.listen_after_bind(); });
  {
    testing::Process browser({"chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader",
                              "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-first-run",
                              "--disable-background-networking", "--disable-component-update", "--disable-sync",
                              "--disable-dev-shm-usage", "--user-data-dir=" + (folder / "profile").string(),
                              "http://127.0.0.1:" + std::to_string(port) + "/ask.html"});
    auto answer = done.get_future();
    if (answer.wait_for(std::chrono::seconds(120)) == std::future_status::ready)
      shown.figures = Json::parse(answer.get());
    else
      shown.figures = {{"failure", "the browser did not answer: " + browser.output()}};
    browser.kill();
  }
  server.stop();
  serving.join();
  return shown;
}

/// From these eyes; `lose`: twice from each, the second time when the page has lost its graphics and got them back.
Shown shown_in_browser(const fs::path& folder, const std::vector<Eye>& eyes, bool lose = false) {
  Json list = Json::array();
  for (const Eye& eye : eyes)
    list.push_back({{"eye", numbers(eye.place)}, {"target", numbers(eye.target)}, {"up", numbers(eye.up)}});
  return shown_in_browser(folder, {{"eyes", list}, {"lights", Json::array()}, {"lose", lose}});
}

/// How far a picture is off, where no outline of the surface runs near.
struct Difference {
  double mean = 0;
  std::size_t values = 0, off = 0;  ///< by more than 2 of 255
  std::size_t missing = 0;          ///< pixels of one that the other has not
};

Difference difference(const ImageU8& shown, const ImageU8& truth, const ImageU8& outline) {
  Difference difference;
  for (int y = 1; y < kHeight - 1; ++y)
    for (int x = 1; x < kWidth - 1; ++x) {
      bool near_outline = false;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) near_outline |= outline.at(x + dx, y + dy) > 0;
      if (near_outline) continue;
      if (shown.at(x, y, 3) != truth.at(x, y, 3)) ++difference.missing;
      if (truth.at(x, y, 3) == 0) continue;
      for (int c = 0; c < 3; ++c, ++difference.values) {
        const int off = std::abs(int{shown.at(x, y, c)} - int{truth.at(x, y, c)});
        difference.off += off > 2 ? 1 : 0;
        difference.mean += off;
      }
    }
  difference.mean /= static_cast<double>(std::max<std::size_t>(difference.values, 1));
  return difference;
}

/// On all sides of the object, near and far, the camera upright in the object's frame.
std::vector<Eye> eyes_round(const BoundingSphere& object, int count) {
  std::vector<Eye> eyes;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count, turn = 2.4 * i, level = std::sqrt(1 - z * z);
    const Eigen::Vector3d direction(level * std::cos(turn), level * std::sin(turn), z);
    eyes.push_back({object.centre + (2.2 + 0.4 * (i % 4)) * object.radius * direction,
                    object.centre + 0.1 * object.radius * Eigen::Vector3d(std::sin(i), std::cos(i), 0.3),
                    Eigen::Vector3d::UnitZ()});
  }
  return eyes;
}

Camera camera() {
  Camera camera{.width = kWidth, .height = kHeight};
  camera.fx = camera.fy = 0.5 * kHeight / kTanHalfView;
  camera.cx = 0.5 * kWidth - 0.5;
  camera.cy = 0.5 * kHeight - 0.5;
  return camera;
}

class ModelPage : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v chromium > /dev/null 2>&1") != 0) GTEST_SKIP() << "chromium is not installed";
    if (!fs::exists(SHEEN_PAGE_FOLDER "/light_field.wasm"))
      GTEST_SKIP() << "this build has no page (deploy/install packages-wasm.txt, then build again)";
  }
  TempFolder folder_;
};

TEST_F(ModelPage, ShowsThePicturesOfTheRayPainter) {
  const fs::path file = SHEEN_GOLDEN_FOLDER "/sphere.slf";
  write_page(file, folder_.path() / "page", page_text(file));
  const SavedModel saved = open_model(file);
  const Mesh& mesh = saved.snapshot->mesh();
  const std::vector<Eye> eyes = eyes_round(bounding_sphere(mesh), 8);
  const Shown shown = shown_in_browser(folder_.path(), eyes);
  EXPECT_EQ(shown.figures.at("failure"), "");
  ASSERT_EQ(shown.pictures.size(), eyes.size());

  const RayPainter painter(mesh);
  const Outlines outlines(mesh);
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const Rigid3 pose = look_at(eyes[i].place, eyes[i].target, eyes[i].up);
    const ImageU8 truth = straight_srgb8(painter.paint_smooth(*saved.snapshot, outlines, camera(), pose));
    const Difference off = difference(shown.pictures[i], truth, outlines.pixels(camera(), pose));
    EXPECT_GT(off.values, 10'000) << "eye " << i;
    EXPECT_EQ(off.missing, 0) << "eye " << i;
    EXPECT_LE(off.off, 3) << "eye " << i << ": no more than a pixel whose ray meets the edge of two triangles";
    EXPECT_LE(off.mean, 0.25) << "eye " << i;
  }
}

TEST_F(ModelPage, ShowsAnIrradianceFieldInAnyLight) {
  const fs::path file = SHEEN_GOLDEN_FOLDER "/relief.rif";
  write_page(file, folder_.path() / "page", page_text(file));
  const SavedModel saved = open_model(file);
  const PosedCamera& from = saved.snapshot->cameras().front();
  const RayPainter painter(saved.snapshot->mesh());
  std::vector<Eigen::Vector3d> lights{saved.snapshot->lights().front().position};
  for (int i = 0; i < 8; ++i) {
    const double turn = 2.4 * i, lean = 0.15 * i;
    lights.emplace_back(std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean));
  }
  Json list = Json::array();
  for (const Eigen::Vector3d& light : lights) list.push_back(numbers(light));
  const Shown shown = shown_in_browser(folder_.path(), {{"eyes", Json::array()}, {"lights", list}, {"lose", false}});
  EXPECT_EQ(shown.figures.at("failure"), "");
  ASSERT_EQ(shown.pictures.size(), lights.size());
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const ImageU8 truth = to_srgb8(painter
                                       .paint(*saved.snapshot, from.camera, from.camera_from_object,
                                              {.kind = LightKind::kDirectional, .position = lights[i]})
                                       .beauty);
    const ImageU8& picture = shown.pictures[i];
    ASSERT_EQ(picture.width(), truth.width());
    ASSERT_EQ(picture.height(), truth.height());
    int most = 0;
    double mean = 0;
    for (int y = 0; y < truth.height(); ++y)
      for (int x = 0; x < truth.width(); ++x)
        for (int c = 0; c < 3; ++c) {
          const int off = std::abs(int{picture.at(x, y, c)} - int{truth.at(x, y, c)});
          most = std::max(most, off);
          mean += off;
        }
    EXPECT_LE(most, 2) << "light " << i;
    EXPECT_LE(mean / static_cast<double>(truth.size()), 0.25) << "light " << i;
  }
}

TEST_F(ModelPage, IsOneFileToo) {
  make_folder(folder_.path() / "page");
  for (const char* name : {"sphere.slf", "relief.rif"}) {
    const fs::path file = fs::path(SHEEN_GOLDEN_FOLDER) / name;
    write_single_page(file, folder_.path() / "page" / "index.html", page_text(file));
    const Shown shown = shown_in_browser(folder_.path(), std::vector<Eye>{});
    EXPECT_EQ(shown.figures.at("failure"), "") << name;
    EXPECT_EQ(shown.figures.at("state"), "whole") << name;
  }
}

TEST_F(ModelPage, ShowsTheSameAfterTheGraphicsWereLost) {
  const fs::path file = SHEEN_GOLDEN_FOLDER "/sphere.slf";
  write_page(file, folder_.path() / "page", page_text(file));
  const Shown shown = shown_in_browser(folder_.path(), std::vector<Eye>{{{1, -2, 0.5}, {0, 0, 0}, {0, 0, 1}}}, true);
  EXPECT_EQ(shown.figures.at("failure"), "");
  ASSERT_EQ(shown.pictures.size(), 2);
  EXPECT_TRUE(std::equal(shown.pictures[0].data(), shown.pictures[0].data() + shown.pictures[0].size(),
                         shown.pictures[1].data()));
}

TEST_F(ModelPage, ACutFileIsAPictureAndADamagedOneANamedError) {
  const fs::path file = SHEEN_GOLDEN_FOLDER "/sphere.slf", page = folder_.path() / "page";
  const std::string bytes = read_file(file);
  write_page(file, page, page_text(file));
  write_file(page / "model.slf", bytes.substr(0, bytes.find("STAT")));
  const Shown cut = shown_in_browser(folder_.path(), std::vector<Eye>{{{1, -2, 0.5}, {0, 0, 0}, {0, 0, 1}}});
  EXPECT_EQ(cut.figures.at("failure"), "");
  EXPECT_GT(cut.figures.at("missingLayers"), 0);
  EXPECT_EQ(cut.pictures.size(), 1);

  std::string damaged = bytes;
  damaged[bytes.find("VERT") + 40] ^= 1;
  write_file(page / "model.slf", damaged);
  fs::remove_all(folder_.path() / "profile");
  const Shown none = shown_in_browser(folder_.path(), std::vector<Eye>{});
  EXPECT_EQ(none.figures.at("state"), "failed");
  EXPECT_THAT(none.figures.at("failure").get<std::string>(), ::testing::HasSubstr("chunk \"VERT\" is damaged"));
}

}  // namespace
}  // namespace sheen
