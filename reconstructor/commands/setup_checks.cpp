// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/setup_checks.h"

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <thread>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/quantity.h"
#include "common/geometry/mesh.h"
#include "common/link/endpoint.h"
#include "common/link/transport.h"
#include "common/session/session.h"
#include "reconstructor/monitor/monitor_server.h"
#include "reconstructor/numerics/self_test.h"
#include "reconstructor/scene/mesh_scale.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr double kGigabyte = 1e9;
constexpr double kLeastRoom = 1 * kGigabyte;
constexpr double kSmallestObject_m = 0.002, kLargestObject_m = 10;  // of the longest side; beyond, a unit is likelier
constexpr double kAmpleRoom = 10 * kGigabyte;  // 300 images of 1024x768 take about 0.3 GB, photographs ten times that

struct Address {
  std::string host, port;
};

bool parse_tcp(const std::string& endpoint, Address& address) {
  constexpr std::string_view kScheme = "tcp://";
  const std::size_t colon = endpoint.rfind(':');
  if (!endpoint.starts_with(kScheme) || colon < kScheme.size() + 1 || colon + 1 == endpoint.size()) return false;
  address = {endpoint.substr(kScheme.size(), colon - kScheme.size()), endpoint.substr(colon + 1)};
  if (address.host.starts_with("[") && address.host.ends_with("]"))
    address.host = address.host.substr(1, address.host.size() - 2);
  return true;
}

/// 0, or the reason as errno has it.
int try_connect(const addrinfo& to, std::chrono::milliseconds timeout) {
  const int socket = ::socket(to.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket < 0) return errno;
  int result = ::connect(socket, to.ai_addr, to.ai_addrlen) == 0 ? 0 : errno;
  if (result == EINPROGRESS) {
    pollfd writable{socket, POLLOUT, 0};
    socklen_t size = sizeof(result);
    if (::poll(&writable, 1, static_cast<int>(timeout.count())) <= 0)
      result = ETIMEDOUT;
    else
      ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &result, &size);
  }
  ::close(socket);
  return result;
}

SetupCheck check_room(const fs::path& folder) {
  std::error_code error;
  fs::path existing = fs::absolute(folder, error);
  while (!existing.empty() && existing != existing.root_path() && !fs::exists(existing, error))
    existing = existing.parent_path();
  const fs::space_info space = fs::space(existing, error);
  if (error) return {"disk", Finding::kFail, existing.string() + ": " + error.message()};
  const auto free = static_cast<double>(space.available);
  const std::string text = gigabytes(free) + " free at " + existing.string();
  if (free < kLeastRoom) return {"disk", Finding::kFail, text + "; make room, or keep the session on another disk"};
  if (free < kAmpleRoom) return {"disk", Finding::kWarn, text + "; a long capture may fill it"};
  return {"disk", Finding::kOk, text};
}

}  // namespace

std::vector<SetupCheck> check_mesh(const fs::path& mesh) {
  try {
    const LoadedMesh loaded = load_mesh(mesh);
    const MeshDiagnosis& diagnosis = loaded.diagnosis;
    std::vector<SetupCheck> checks{{"mesh", Finding::kOk,
                                    mesh.string() + ": " + std::to_string(diagnosis.triangles) + " triangles, " +
                                        std::to_string(diagnosis.vertices) + " vertices, " + size_text(loaded.mesh)}};
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& vertex : loaded.mesh.vertices) box.extend(vertex);
    const double side = box.sizes().maxCoeff();
    if (side < kSmallestObject_m || side > kLargestObject_m) {
      checks.front().finding = Finding::kWarn;
      checks.front().text += "; a mesh is in metres: is this one in " +
                             std::string(side > kLargestObject_m ? "millimetres" : "another unit") +
                             "? `sheen-tracker register --unit` brings it to metres";
    }
    for (const std::string& warning : diagnosis.warnings()) checks.push_back({"mesh", Finding::kWarn, warning});
    return checks;
  } catch (const Error& error) {
    return {{"mesh", Finding::kFail, error.what()}};
  }
}

SetupCheck check_secret_key(const fs::path& key_file) {
  return check_loading(
      "keys", [&] { return load_keys(key_file), key_file.string(); }, "`sheen-tracker keygen` makes keys");
}

SetupCheck check_public_key(const fs::path& pub_file) {
  return check_loading(
      "tracker's key", [&] { return load_public_key(pub_file), pub_file.string(); },
      "copy the tracker's .pub file here");
}

SetupCheck check_endpoint(const std::string& endpoint, bool has_keys, std::chrono::milliseconds timeout) {
  const std::string name = "tracker";
  Address address;
  if (const std::string error = endpoint_error(endpoint); !error.empty()) return {name, Finding::kFail, error};
  if (!parse_tcp(endpoint, address))
    return {name, Finding::kFail, "\"" + endpoint + "\" is not an endpoint; write it as tcp://HOST:PORT"};
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); error != 0)
    return {name, Finding::kFail, endpoint + ": " + ::gai_strerror(error) + "; is the host's name right?"};
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses(found, &::freeaddrinfo);
  const bool loopback = address.host == "localhost" || address.host == "::1" || address.host.starts_with("127.");
  if (!loopback && !has_keys)
    return {name, Finding::kFail, endpoint + " leaves this machine, which needs keys: give --keys and --tracker-key"};

  const int reason = try_connect(*addresses, timeout);
  if (reason == 0) return {name, Finding::kOk, endpoint + " answers"};
  if (reason == ECONNREFUSED)
    return {name, Finding::kWarn, endpoint + ": nobody listens; start `sheen-tracker run` there, now or later"};
  return {name, Finding::kWarn,
          endpoint + ": " + std::strerror(reason) + "; is the host on, the network connected, the port not filtered?"};
}

std::vector<SetupCheck> check_session(const fs::path& folder) {
  std::vector<SetupCheck> checks;
  try {
    if (Session::exists(folder)) {
      const Session session = Session::open_read_only(folder);
      checks.push_back({"session", Finding::kOk,
                        folder.string() + ": version " + std::to_string(kSessionVersion) + ", " +
                            std::to_string(session.size()) + " captures, will be continued"});
    } else {
      checks.push_back({"session", Finding::kOk, folder.string() + ": will be created"});
      std::error_code error;
      if (fs::exists(folder, error) && !fs::is_empty(folder, error))
        checks.back() = {"session", Finding::kFail,
                         folder.string() + " holds other files; name an empty or a new folder"};
    }
  } catch (const Error& error) {
    checks.push_back({"session", Finding::kFail, error.what()});
  }
  checks.push_back(check_room(folder));
  return checks;
}

SetupCheck check_monitor_port(int port) {
  try {
    const MonitorServer server({.port = port});
    return {"monitor page", Finding::kOk, server.url() + " is free"};
  } catch (const Error& error) {
    return {"monitor page", Finding::kFail, error.what()};  // `serve` does not start so
  }
}

SetupCheck check_display() {
  const char* x11 = std::getenv("DISPLAY");
  const char* wayland = std::getenv("WAYLAND_DISPLAY");
  if ((x11 == nullptr || *x11 == '\0') && (wayland == nullptr || *wayland == '\0'))
    return {"display", Finding::kOk, "no display, so no window; the monitor page and `render` need none"};
  const std::string display = wayland != nullptr && *wayland != '\0' ? wayland : x11;
  if (display.starts_with(":") && !fs::exists("/tmp/.X11-unix/X" + display.substr(1, display.find('.') - 1)))
    return {"display", Finding::kWarn,
            "DISPLAY is " + display + ", but no X server runs there; unset it, or start one"};
  return {"display", Finding::kOk, display};
}

std::vector<SetupCheck> check_numerics() {
  std::vector<SetupCheck> checks;
  for (const NumericsCheck& check : numerics_self_test())
    checks.push_back({"numerics", check.holds() ? Finding::kOk : Finding::kFail,
                      check.name + format(" %.3g, at most %.3g", check.value, check.bound) +
                          (check.holds() ? ""
                                         : "; this program does not compute as it should here: build it for "
                                           "this processor, and report the line")});
  return checks;
}

SetupCheck check_processor() {
  const unsigned threads = std::max(1U, std::thread::hardware_concurrency());
  std::string text = std::to_string(threads) + " threads";
#if defined(__AVX512F__)
  text += ", built for AVX-512";
#elif defined(__AVX2__)
  text += ", built for AVX2";
#elif defined(__x86_64__)
  if (__builtin_cpu_supports("avx2"))
    return {"processor", Finding::kWarn,
            text + ", has AVX2, but this program was built for any x86-64: configure with -DSHEEN_ARCH=native"};
#endif
  if (threads < 2) return {"processor", Finding::kWarn, text + "; a live capture needs two or more"};
  return {"processor", Finding::kOk, text};
}

}  // namespace sheen
