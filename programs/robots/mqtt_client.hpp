// A connection to an MQTT broker that comes back when the broker does. Everything happens in poll(), in the caller's
// thread.
#pragma once

#include <functional>
#include <set>
#include <string>

#include "loop/exchange/order_exchange.hpp"

struct mosquitto;

namespace plumbline::loop {

struct BrokerOptions {
  std::string host = "127.0.0.1";
  int port = 1883;
  std::string id;              ///< of this client at the broker
  std::string user, password;  ///< empty: none
  std::string ca_file, certificate,
      key;  ///< TLS where `ca_file` is given; certificate and key of this client may be empty
};

/// Empty if a broker may be spoken to so; else why not: a drill obeys what comes through it, so without TLS only this
/// machine's own addresses are taken.
std::string broker_objection(const BrokerOptions& options);

class MqttClient {
 public:
  /// Does not wait for the broker. Throws std::runtime_error for options that cannot be: broker_objection(), a file
  /// that TLS does not take.
  explicit MqttClient(const BrokerOptions& options);
  ~MqttClient();
  MqttClient(const MqttClient&) = delete;
  MqttClient& operator=(const MqttClient&) = delete;

  /// Now, and whenever the broker comes back.
  void subscribe(const std::string& topic);
  /// At least once, if the broker is there; false if it is not.
  bool publish(const MqttMessage& message);
  /// Works for `seconds` at most.
  void poll(double seconds);
  bool is_connected() const { return connected_; }
  /// Why it is not connected, in words; empty: it is, or nobody has tried yet.
  const std::string& trouble() const { return trouble_; }

  /// `is_kept`: the broker had retained it, and nobody says it now.
  std::function<void(const std::string& topic, const std::string& payload, bool is_kept)> on_message;
  std::function<void()> on_connect;

 private:
  void set_up_tls(const BrokerOptions& options);
  static void connected(mosquitto* broker, void* self, int code);
  static void disconnected(mosquitto* broker, void* self, int code);

  BrokerOptions options_;
  mosquitto* mosquitto_ = nullptr;
  bool tried_ = false, connected_ = false;
  std::string trouble_;
  std::set<std::string> topics_;
};

}  // namespace plumbline::loop
