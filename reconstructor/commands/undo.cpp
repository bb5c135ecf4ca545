// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/session/session.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/commands.h"

namespace sheen {
namespace {

struct UndoArguments {
  std::string session, name;
  std::optional<std::uint64_t> capture;
  bool last = false, list = false, restore = false, json = false;
};

/// Of a capture whose file cannot be read, nothing.
std::optional<CaptureLabel> label_of(const Session& session, std::uint64_t capture) {
  try {
    return session.label(capture);
  } catch (const DamagedCapture& error) {
    std::cerr << error.what() << '\n';
    return std::nullopt;
  }
}

void list(const Session& session, bool as_json) {
  const std::set<std::uint64_t> withdrawn = session.withdrawn();
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (std::uint64_t i = 0; i < session.size(); ++i) {
    const std::optional<CaptureLabel> label = label_of(session, i);
    const CaptureLabel shown = label.value_or(CaptureLabel{});
    if (as_json)
      rows.push_back({{"capture", i},
                      {"name", shown.name},
                      {"source_session", shown.source_session},
                      {"sequence", shown.sequence},
                      {"damaged", !label},
                      {"withdrawn", withdrawn.contains(i)}});
    else
      std::cout << i << '\t'
                << (withdrawn.contains(i) ? "withdrawn"
                    : label               ? "kept"
                                          : "damaged")
                << '\t' << shown.name << '\n';
  }
  if (as_json) std::cout << rows.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
}

std::uint64_t find_by_name(const Session& session, const UndoArguments& arguments) {
  std::vector<std::uint64_t> found;
  for (std::uint64_t i = 0; i < session.size(); ++i) {
    const std::string name = label_of(session, i).value_or(CaptureLabel{}).name;
    if (name == arguments.name || std::filesystem::path(name).filename() == arguments.name) found.push_back(i);
  }
  if (found.empty())
    throw FileError(arguments.session, "has no capture named '" + arguments.name + "'; --list names all of them");
  if (found.size() == 1) return found.front();
  std::string numbers;
  for (const std::uint64_t i : found) numbers += " " + std::to_string(i);
  throw FileError(arguments.session,
                  "has several captures named '" + arguments.name + "':" + numbers + "; say which with --capture");
}

std::uint64_t chosen(const Session& session, const UndoArguments& arguments) {
  if (arguments.capture) return *arguments.capture;
  if (!arguments.name.empty()) return find_by_name(session, arguments);
  const std::optional<std::uint64_t> last = session.last();
  if (!last) throw FileError(arguments.session, "has no capture that could be taken back");
  return *last;
}

void undo(const UndoArguments& arguments) {
  const int ways = arguments.last + arguments.capture.has_value() + !arguments.name.empty() + arguments.list;
  if (ways != 1) throw ConfigError("undo: give one of --last, --capture, --name or --list");
  if (arguments.restore && (arguments.last || arguments.list))
    throw ConfigError("undo: --restore needs --capture or --name");
  if (arguments.list) return list(Session::open_read_only(arguments.session), arguments.json);

  Session session = Session::open_to_withdraw(arguments.session);
  const std::uint64_t capture = chosen(session, arguments);
  const bool changed = session.set_withdrawn(capture, !arguments.restore);
  if (arguments.json) {
    std::cout << nlohmann::json{{"capture", capture}, {"withdrawn", !arguments.restore}, {"changed", changed}} << '\n';
    return;
  }
  std::printf("capture %llu %s %s\n", static_cast<unsigned long long>(capture), changed ? "is" : "was already",
              arguments.restore ? "put back" : "withdrawn");
  const std::filesystem::path model = std::filesystem::path(arguments.session) / kSessionModel;
  if (changed && std::filesystem::exists(model))
    std::printf(
        "a running `serve` follows. Without one, %s stays as it was: rebuild it with `sheen-reconstructor build %s "
        "--mesh MESH --out %s`\n",
        model.c_str(), arguments.session.c_str(), model.c_str());
}

}  // namespace

void add_undo_command(Command& program) {
  auto arguments = std::make_shared<UndoArguments>();
  Command command = program.subcommand(
      "undo",
      "Takes back an image of a session, also while `serve` records it: the image stays there with a mark, and "
      "models leave it out.");
  command.option("session", arguments->session, "folder of the session").required();
  command.flag("--last", arguments->last, "the last image that is not withdrawn");
  command.option("--capture", arguments->capture, "an image by its number, from 0")
      .check(whole_number_in(0, std::numeric_limits<std::int64_t>::max()));
  command.option("--name", arguments->name, "an image by its name, with or without folders");
  command.flag("--list", arguments->list, "list numbers, states and names");
  command.flag("--restore", arguments->restore, "put the image back instead");
  command.flag("--json", arguments->json, "print JSON");
  command.callback([arguments] { undo(*arguments); });
}

}  // namespace sheen
