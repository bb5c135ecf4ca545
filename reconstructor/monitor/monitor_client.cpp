// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/monitor_client.h"

#include <httplib.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/format.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

constexpr std::chrono::seconds kTimeout{3};

/// httplib takes any number for a port, and of one that is too large the lower 16 bits.
void require_port(const std::string& url) {
  const std::size_t host = url.find("//") + 2, end = url.find('/', host);
  const std::string authority = url.substr(host, end == std::string::npos ? end : end - host);
  const std::size_t colon = authority.rfind(':');
  if (colon == std::string::npos || authority.ends_with("]")) return;
  const std::string port = authority.substr(colon + 1);
  if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string::npos ||
      std::stoi(port) < 1 || std::stoi(port) > 65535)
    throw ConfigError("\"" + url + "\": " + port + " is not a port; give one from 1 to 65535");
}

std::string described(const Json& status) {
  const Json& frames = status.at("frames");
  std::string line = status.at("state").get<std::string>();
  if (const auto ending = status.find("ending"); ending != status.end() && ending->is_object())
    line += " " + std::to_string(ending->at("done").get<std::uint64_t>()) + "/" +
            std::to_string(ending->at("total").get<std::uint64_t>());
  if (const auto error = status.at("error").get<std::string>(); !error.empty()) line += " (" + error + ")";
  line += "  " + std::to_string(frames.at("accepted").get<std::uint64_t>()) + " images of " +
          std::to_string(frames.at("received").get<std::uint64_t>());
  if (const Json& curve = status.at("held_out_curve"); !curve.empty() && curve.back().at("psnr_db").is_number()) {
    const Json& last = curve.back();
    line += format("  %.2f dB", last.at("psnr_db").get<double>());
    if (last.at("constant_psnr_db").is_number())
      line += format(" (constant colour %.2f)", last.at("constant_psnr_db").get<double>());
  }
  if (const Json& rate = status.at("ingest_images_per_s"); rate.is_number() && rate.get<double>() > 0)
    line += format("  %.1f images/s", rate.get<double>());
  if (const auto trade = status.find("trade"); trade != status.end())
    for (const char* limit : {"budget", "memory"})
      if (trade->value(std::string(limit) + "_kept", Json()) == false) line += std::string("  ") + limit + " NOT KEPT";
  for (const auto& [name, queue] : status.at("queues").items()) {
    line += "  " + name + " " + std::to_string(queue.at("depth").get<std::uint64_t>());
    if (const auto capacity = queue.at("capacity").get<std::uint64_t>(); capacity > 0)
      line += "/" + std::to_string(capacity);
  }
  return line;
}

}  // namespace

std::string fetch_status(const std::string& url, const std::string& token) {
  if (!url.starts_with("http://")) throw ConfigError("\"" + url + "\" is not an address; write it as http://HOST:PORT");
  require_port(url);
  httplib::Client client(url.ends_with("/") ? url.substr(0, url.size() - 1) : url);
  if (!client.is_valid()) throw ConfigError("\"" + url + "\" is not an address; write it as http://HOST:PORT");
  client.set_connection_timeout(kTimeout);
  client.set_read_timeout(kTimeout);
  httplib::Headers headers;
  if (!token.empty()) headers.emplace("Authorization", "Bearer " + token);
  const httplib::Result answer = client.Get("/status.json", headers);
  if (!answer)
    throw DeviceError(url + " does not answer (" + httplib::to_string(answer.error()) +
                      "); is sheen-reconstructor running, and is this its monitor page?");
  if (answer->status == 401) throw DeviceError(url + ": the token is missing or wrong; give it with --token-file");
  if (answer->status != 200) throw DeviceError(url + ": answered with status " + std::to_string(answer->status));
  return answer->body;
}

std::string status_line(const std::string& status) {
  try {
    return described(Json::parse(status));
  } catch (const Json::exception& error) {
    throw ProtocolError(std::string("the answer is not a reconstructor's status: ") + error.what());
  }
}

}  // namespace sheen
