// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "reconstructor/monitor/monitor_state.h"
#include "reconstructor/monitor/served_model.h"
#include "reconstructor/monitor/steering.h"

namespace sheen {

struct MonitorOptions {
  std::string host = "127.0.0.1";
  int port = 7480;    ///< 0: any free one, see `MonitorServer::port`
  std::string token;  ///< at least 16 characters; needed where `host` is not loopback. Empty: nobody is asked for one
  std::string steer_token;       ///< of those who may steer, too; at least 16 characters. Empty: nobody may
  Steer steer;                   ///< called on the connections' thread
  ServedModel* model = nullptr;  ///< for desks that draw it themselves; outlives the server
};

/// Serves what was last published over HTTP:
///   /  status page    /status.json    /metrics (Prometheus)    /preview.jpg    /camera.jpg    /healthz
///   /model/  a page that draws the model itself; what it asks for: /model/scene
///   /model/changes?scene=N&changes=N&eye=X,Y,Z(&moved=1)
///   POST /steer?what=undo|hold-out|pause|go-on|note|finish (&text=NOTE), with "Authorization: Bearer STEER_TOKEN":
///   nothing else steers, so that no link and no page of another site can.
/// With a token, every request needs "Authorization: Bearer TOKEN" or "?token=TOKEN" and is answered 401 otherwise;
/// without one, only requests to a loopback host name are answered, so that no web page of another site can read it by
/// pointing its own name here. No client, however slow, keeps another one waiting (HttpConnections).
class MonitorServer {
 public:
  /// Throws ConfigError (a port that is not valid, another address than loopback without a token) and DeviceError (the
  /// port is taken, the address is not this machine's).
  explicit MonitorServer(const MonitorOptions& options);
  ~MonitorServer();  ///< at once, whatever clients do

  /// Replaces what is shown. Never waits for a client.
  void publish(MonitorState state);
  int port() const;
  /// For people: "http://127.0.0.1:7480/", without the token.
  std::string url() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
