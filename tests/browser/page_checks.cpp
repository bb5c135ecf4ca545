// SPDX-License-Identifier: Apache-2.0
#include "tests/browser/page_checks.h"

#include <cmath>
#include <future>
#include <thread>

#include "common/base/files.h"
#include "tests/support/process.h"

// Last: it brings macros that Eigen's headers cannot bear.
#include <httplib.h>

namespace sheen {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kTanHalfView = 0.36397023426620234;  // tan 20 degrees, of the shorter side

/// Shows the page in a frame, asks it for a picture from each eye, or in each light, and posts them.
const char* const kAsking =
    R"html(<!doctype html><iframe src="page/index.html" width="480" height="360" style="border:0"></iframe>
<script>
const post = async (path, body) => (await fetch(path, { method: "POST", body })).text();
const until = async (there) => { while (!there()) await new Promise((go) => setTimeout(go, 20)); };
(async () => {
  const { eyes, lights, lose } = await (await fetch("eyes.json")).json(), frame = document.querySelector("iframe");
  const state = () => frame.contentWindow.sheen?.figures().state;
  await until(() => state() === "whole" || state() === "failed");
  const { sheen } = frame.contentWindow;
  for (const { eye, target, up } of state() === "whole" ? eyes : []) {
    for (let again = "again"; again === "again";) {
      const { pixels } = await sheen.lookFrom(eye, target, up, { markGuesses: false }), { changes } = sheen.figures();
      again = await post("picture", pixels);
      if (again === "again") await until(() => sheen.figures().changes > changes);
    }
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

std::vector<double> numbers(const Eigen::Vector3d& v) {
  return {v.begin(), v.end()};
}

/// The page of a monitor, as if it were in the folder: in a frame of another server it would show nothing.
void pass_on_to_monitor(httplib::Server& server, int port) {
  server.Get("/page/(.*)", [port](const httplib::Request& request, httplib::Response& response) {
    const std::string asked = request.target.substr(std::string("/page/").size());
    const auto answer = httplib::Client("127.0.0.1", port).Get("/model/" + (asked == "index.html" ? "" : asked));
    if (!answer) return;
    response.status = answer->status;
    response.set_content(answer->body, answer->get_header_value("Content-Type"));
  });
}

/// A folder, served to a browser, whose page is asked for pictures, as `asked` says.
Shown shown_in_browser(const fs::path& folder, const Json& asked, const Showing& how) {
  write_file(folder / "eyes.json", asked.dump());
  write_file(folder / "ask.html", kAsking);

  Shown shown;
  std::promise<std::string> done;
  httplib::Server server;
  if (how.port > 0) pass_on_to_monitor(server, how.port);
  server.set_mount_point("/", folder.string());
  server.Post("/picture", [&](const httplib::Request& request, httplib::Response& response) {
    ImageU8 picture(kPageWidth, kPageHeight, 4);
    if (request.body.size() != picture.size()) return;
    for (int y = 0; y < kPageHeight; ++y)  // its bottom row is the first
      std::copy_n(request.body.data() + std::size_t(kPageHeight - 1 - y) * kPageWidth * 4, std::size_t(kPageWidth) * 4,
                  reinterpret_cast<char*>(picture.row(y)));
    shown.pictures.push_back(std::move(picture));
    const bool again = how.change && how.change(shown.pictures.size());
    response.set_content(again ? "again" : "", "text/plain");
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

}  // namespace

Shown shown_in_browser(const fs::path& folder, const std::vector<Eye>& eyes, const Showing& how) {
  Json list = Json::array();
  for (const Eye& eye : eyes)
    list.push_back({{"eye", numbers(eye.place)}, {"target", numbers(eye.target)}, {"up", numbers(eye.up)}});
  return shown_in_browser(folder, {{"eyes", list}, {"lights", Json::array()}, {"lose", how.lose}}, how);
}

Shown lit_in_browser(const fs::path& folder, const std::vector<Eigen::Vector3d>& lights) {
  Json list = Json::array();
  for (const Eigen::Vector3d& light : lights) list.push_back(numbers(light));
  return shown_in_browser(folder, Json{{"eyes", Json::array()}, {"lights", list}, {"lose", false}}, Showing{});
}

Difference difference(const ImageU8& shown, const ImageU8& truth, const ImageU8& outline) {
  Difference difference;
  for (int y = 1; y < kPageHeight - 1; ++y)
    for (int x = 1; x < kPageWidth - 1; ++x) {
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

Camera page_camera() {
  Camera camera{.width = kPageWidth, .height = kPageHeight};
  camera.fx = camera.fy = 0.5 * kPageHeight / kTanHalfView;
  camera.cx = 0.5 * kPageWidth - 0.5;
  camera.cy = 0.5 * kPageHeight - 0.5;
  return camera;
}

}  // namespace sheen
