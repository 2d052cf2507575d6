#include "mqtt_client.hpp"

#include <arpa/inet.h>
#include <mosquitto.h>
#include <mqtt_protocol.h>

#include <chrono>
#include <stdexcept>
#include <thread>

namespace plumbline::loop {
namespace {

constexpr int kKeepAlive = 20;  // [s]

void require(int code, const char* what) {
  if (code != MOSQ_ERR_SUCCESS) throw std::runtime_error(std::string(what) + ": " + mosquitto_strerror(code));
}

}  // namespace

std::string broker_objection(const BrokerOptions& options) {
  // A number, not a name that begins like one: 127.0.0.1.example.org is wherever its owner says.
  in_addr number{};
  const bool own = options.host == "localhost" || options.host == "::1" ||
                   (inet_pton(AF_INET, options.host.c_str(), &number) == 1 && ntohl(number.s_addr) >> 24 == 127);
  if (own || !options.ca_file.empty()) return {};
  return "the broker " + options.host +
         " is not this machine's, and nothing would be encrypted: anybody on the way could send a robot to work; give "
         "--ca (TLS)";
}

MqttClient::MqttClient(const BrokerOptions& options) : options_(options) {
  if (const std::string why = broker_objection(options); !why.empty()) throw std::runtime_error(why);
  mosquitto_lib_init();
  mosquitto_ = mosquitto_new(options.id.empty() ? nullptr : options.id.c_str(), true, this);
  if (!mosquitto_) throw std::runtime_error("the MQTT client cannot be made");
  try {
    require(mosquitto_int_option(mosquitto_, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5), "MQTT 5");
    if (!options.user.empty())
      require(mosquitto_username_pw_set(mosquitto_, options.user.c_str(), options.password.c_str()), "user name");
    if (!options.ca_file.empty()) set_up_tls(options);
  } catch (...) {
    mosquitto_destroy(mosquitto_);
    throw;
  }
  mosquitto_connect_callback_set(mosquitto_, &MqttClient::connected);
  mosquitto_disconnect_callback_set(mosquitto_, &MqttClient::disconnected);
  mosquitto_message_callback_set(mosquitto_, [](mosquitto*, void* self, const mosquitto_message* message) {
    auto* client = static_cast<MqttClient*>(self);
    if (client->on_message)
      client->on_message(
          message->topic,
          std::string(static_cast<const char*>(message->payload), static_cast<std::size_t>(message->payloadlen)),
          message->retain);
  });
}

void MqttClient::set_up_tls(const BrokerOptions& options) {
  const char* certificate = options.certificate.empty() ? nullptr : options.certificate.c_str();
  const char* key = options.key.empty() ? nullptr : options.key.c_str();
  if ((certificate == nullptr) != (key == nullptr))
    throw std::runtime_error(
        "a certificate of this client needs its key, and a key its certificate: give both or none");
  require(mosquitto_tls_set(mosquitto_, options.ca_file.c_str(), nullptr, certificate, key, nullptr),
          ("TLS with " + options.ca_file).c_str());
}

MqttClient::~MqttClient() {
  mosquitto_disconnect(mosquitto_);
  mosquitto_destroy(mosquitto_);
  mosquitto_lib_cleanup();
}

void MqttClient::connected(mosquitto*, void* self, int code) {
  auto* client = static_cast<MqttClient*>(self);
  client->connected_ = code == 0;
  client->trouble_ = code == 0 ? std::string() : std::string("the broker refuses: ") + mosquitto_reason_string(code);
  if (code != 0) return;
  for (const std::string& topic : client->topics_) mosquitto_subscribe(client->mosquitto_, nullptr, topic.c_str(), 1);
  if (client->on_connect) client->on_connect();
}

void MqttClient::disconnected(mosquitto*, void* self, int) {
  auto* client = static_cast<MqttClient*>(self);
  client->connected_ = false;
  if (client->trouble_.empty()) client->trouble_ = "the broker is away";
}

void MqttClient::subscribe(const std::string& topic) {
  topics_.insert(topic);
  if (connected_) mosquitto_subscribe(mosquitto_, nullptr, topic.c_str(), 1);
}

bool MqttClient::publish(const MqttMessage& message) {
  if (!connected_) return false;
  mosquitto_property* properties = nullptr;
  if (message.expires > 0)
    mosquitto_property_add_int32(&properties, MQTT_PROP_MESSAGE_EXPIRY_INTERVAL,
                                 static_cast<std::uint32_t>(message.expires));
  const int code =
      mosquitto_publish_v5(mosquitto_, nullptr, message.topic.c_str(), static_cast<int>(message.payload.size()),
                           message.payload.data(), 1, false, properties);
  mosquitto_property_free_all(&properties);
  return code == MOSQ_ERR_SUCCESS;
}

void MqttClient::poll(double seconds) {
  int code = tried_ ? mosquitto_loop(mosquitto_, static_cast<int>(1e3 * seconds), 1) : MOSQ_ERR_NO_CONN;
  if (code == MOSQ_ERR_SUCCESS) return;
  connected_ = false;
  code = tried_ ? mosquitto_reconnect(mosquitto_)
                : mosquitto_connect(mosquitto_, options_.host.c_str(), options_.port, kKeepAlive);
  // A first attempt that failed knows the address all the same: the next is a reconnection.
  tried_ = true;
  if (code != MOSQ_ERR_SUCCESS) {
    trouble_ = "the broker at " + options_.host + ":" + std::to_string(options_.port) +
               " is away: " + mosquitto_strerror(code) + "; tried again until it is there (--host, --port)";
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  }
}

}  // namespace plumbline::loop
