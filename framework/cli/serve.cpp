// plumbline serve: the runs below a folder as a page on this machine, which follows them as they go.
//
// Who may look: whoever has the token, which the program prints with the address. The Host of a request must be ours,
// so that no page of somebody else's gets an answer by a name that it lets point here (DNS rebinding). What lies in the
// folder was written by runs and is not trusted to act for whoever looks: files are shown in a sandbox without the
// page's origin.
#include <fmt/core.h>
#include <sys/random.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "http_server.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/record/run_record.hpp"
#include "serve_page.hpp"
#include "served_runs.hpp"
#include "stopping.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t largest_artifact = 8 * 1024 * 1024;

std::string random_hex() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("the system gives no random numbers for the token");
  std::string text;
  for (const unsigned char byte : bytes) {
    text += fmt::format("{:02x}", byte);
  }
  return text;
}

/// In a time that does not tell how much of it was right.
bool same(const std::string& a, const std::string& b) {
  unsigned char difference = a.size() == b.size() ? 0 : 1;
  for (size_t i = 0; i < a.size() && i < b.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

std::string value_of(const std::map<std::string, std::string>& map, const std::string& name) {
  const auto found = map.find(name);
  return found == map.end() ? "" : found->second;
}

const char* type_of(const std::string& path) {
  static constexpr std::pair<const char*, const char*> types[] = {{".html", "text/html; charset=utf-8"},
                                                                  {".json", "application/json"},
                                                                  {".svg", "image/svg+xml"},
                                                                  {".png", "image/png"},
                                                                  {".jpg", "image/jpeg"},
                                                                  {".jpeg", "image/jpeg"},
                                                                  {".JPG", "image/jpeg"},
                                                                  {".pdf", "application/pdf"}};
  for (const auto& [end, type] : types)
    if (path.ends_with(end)) return type;
  for (const char* end : {".txt", ".csv", ".xml", ".md", ".yaml", ".jsonl", ".tex", ".gsi", ".xyz"})
    if (path.ends_with(end)) return "text/plain; charset=utf-8";
  return "application/octet-stream";
}

HttpAnswer json_answer(const Json& json, int status = 200) {
  HttpAnswer answer;
  answer.status = status;
  answer.type = "application/json";
  answer.body = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  return answer;
}

HttpAnswer text_answer(int status, const std::string& text) {
  HttpAnswer answer;
  answer.status = status;
  answer.body = text + "\n";
  return answer;
}

class Site {
 public:
  Site(const Options& options, const std::string& folder, const std::string& host)
      : options_(options), folder_(folder), host_(host), token_(random_hex()), runs_(folder), registry_(discover()) {}

  void listens_on(int port) {
    port_ = port;
    cookie_ = "plumbline_" + std::to_string(port);
  }
  std::string address() const {
    const std::string shown = host_ == "0.0.0.0" || host_ == "::" ? "127.0.0.1" : host_;
    return "http://" + (shown.find(':') == std::string::npos ? shown : "[" + shown + "]") + ":" +
           std::to_string(port_) + "/?token=" + token_;
  }

  HttpAnswer answer(const HttpRequest& request) {
    HttpAnswer given = answered(request);
    given.headers.insert(given.headers.end(), {{"X-Content-Type-Options", "nosniff"},
                                               {"Referrer-Policy", "no-referrer"},
                                               {"Cross-Origin-Resource-Policy", "same-origin"},
                                               {"Cache-Control", "no-store"}});
    return given;
  }

 private:
  HttpAnswer answered(const HttpRequest& request) {
    if (!is_our_host(value_of(request.headers, "host")))
      return text_answer(421, "this server answers under " + host_ + " and localhost only");
    if (const std::string given = value_of(request.query, "token"); !given.empty()) return let_in(given);
    if (!is_let_in(request))
      return text_answer(401,
                         "the address needs the token that plumbline serve printed: " + std::string("/?token=..."));
    if (request.path == "/") return page();
    if (request.path == "/api/runs") return json_answer({{"folder", folder_}, {"runs", runs_.list()}});
    if (request.path == "/api/run") return run(value_of(request.query, "id"));
    if (request.path == "/api/diff") return difference(request);
    if (request.path == "/api/artifact") return artifact(request);
    if (request.path.starts_with("/files/")) return file(request.path.substr(7));
    return text_answer(404, "there is nothing at " + request.path);
  }

  /// Names that mean this machine, and numbers where we listen to more than it: a rebound name is neither.
  bool is_our_host(const std::string& given) const {
    std::string name = given, port;
    const size_t bracket = given.find(']'), colon = given.rfind(':');
    if (colon != std::string::npos && (bracket == std::string::npos || colon > bracket))
      name = given.substr(0, colon), port = given.substr(colon + 1);
    if (port.empty() ? port_ != 80 : port != std::to_string(port_)) return false;
    if (name.size() > 2 && name.front() == '[' && name.back() == ']') name = name.substr(1, name.size() - 2);
    if (name == host_ || name == "127.0.0.1" || name == "localhost" || name == "::1") return true;
    if (host_ != "0.0.0.0" && host_ != "::") return false;
    std::array<char, 256> own{};
    gethostname(own.data(), own.size() - 1);
    return name == own.data() || (!name.empty() && name.find_first_not_of("0123456789.") == std::string::npos) ||
           name.find(':') != std::string::npos;
  }

  /// The token leaves the address at once: it would stay in the browser's history otherwise.
  HttpAnswer let_in(const std::string& given) const {
    if (!same(given, token_)) return text_answer(401, "this is not the token that plumbline serve printed");
    HttpAnswer answer = text_answer(303, "");
    answer.headers.push_back({"Location", "/"});
    answer.headers.push_back({"Set-Cookie", cookie_ + "=" + token_ + "; HttpOnly; SameSite=Lax; Path=/"});
    return answer;
  }

  bool is_let_in(const HttpRequest& request) const {
    if (const std::string given = value_of(request.headers, "authorization"); !given.empty())
      return same(given, "Bearer " + token_);
    const std::string cookies = value_of(request.headers, "cookie");
    for (size_t at = 0; at < cookies.size();) {
      const size_t end = std::min(cookies.find(';', at), cookies.size());
      const std::string one = cookies.substr(at, end - at);
      if (same(one, cookie_ + "=" + token_)) return true;
      at = std::min(cookies.find_first_not_of("; ", end), cookies.size());
    }
    return false;
  }

  static HttpAnswer page() {
    HttpAnswer answer;
    answer.type = "text/html; charset=utf-8";
    const std::string nonce = random_hex(), mark = "@nonce@";
    answer.body = serve_page;
    for (size_t at; (at = answer.body.find(mark)) != std::string::npos;) answer.body.replace(at, mark.size(), nonce);
    answer.headers.push_back(
        {"Content-Security-Policy",
         "default-src 'none'; connect-src 'self'; frame-src 'self'; img-src data:; style-src 'nonce-" + nonce +
             "'; script-src 'nonce-" + nonce + "'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"});
    return answer;
  }

  HttpAnswer run(const std::string& id) {
    const Json json = runs_.run(id);
    return json.is_null() ? text_answer(404, "there is no run '" + id + "'") : json_answer(json);
  }

  HttpAnswer difference(const HttpRequest& request) {
    const fs::path a = runs_.record(value_of(request.query, "a")), b = runs_.record(value_of(request.query, "b"));
    if (a.empty() || b.empty()) return text_answer(404, "two runs of the list are needed: a and b");
    const auto store = open_store_to_read(options_);
    const auto found = compare_runs(runtime::read_run(a), runtime::read_run(b), 0, store.get(), registry_);
    Json json = Json::array();
    for (const auto& node : found) json.push_back({{"node", node.node}, {"differences", node.lines}});
    return json_answer({{"nodes", json}});
  }

  /// "fit@2" of a node that ran in rounds; of "fit" alone the last of them, which is what the run handed over.
  static std::string with_its_round(const Json& run, const std::string& node) {
    std::string found = node;
    for (const Json& one : run["nodes"])
      if (one.value("name", "") == node) found = ServedRuns::name_of(one);
    return found;
  }

  HttpAnswer artifact(const HttpRequest& request) {
    const Json run = runs_.run(value_of(request.query, "id"));
    if (run.is_null()) return text_answer(404, "there is no such run");
    const std::string port = value_of(request.query, "port");
    const std::string node = with_its_round(run, value_of(request.query, "node"));
    const std::string number = value_of(request.query, "item");
    const size_t item = number.size() < 7 ? static_cast<size_t>(std::atoi(number.c_str())) : 0;
    for (const Json& one : run["nodes"]) {
      // A record may say anything, and leave anything out.
      const Json outputs = one.value("outputs", Json::object());
      if (ServedRuns::name_of(one) != node || !outputs.contains(port)) continue;
      if (!outputs[port].is_array()) break;
      const auto hashes = outputs[port].get<std::vector<std::string>>();
      const plumbline_type* type =
          registry_.type_of_output(one.value("kind", ""), port, one.value("types", Json::object()).value(port, ""));
      if (item >= hashes.size() || !type) break;
      const std::string text = blob_to_json(*open_store_to_read(options_), *type, hashes[item]);
      if (text.size() > largest_artifact)
        return text_answer(200, "It has " + std::to_string(text.size() >> 20) + " MiB as text: plumbline show " +
                                    value_of(request.query, "id") + "/run.jsonl:" + node + "." + port);
      HttpAnswer answer;
      answer.type = "application/json";
      answer.body = text;
      return answer;
    }
    return text_answer(404, "this run has no such artifact");
  }

  HttpAnswer file(const std::string& path) {
    const ServedRuns::File found = runs_.open(path);
    if (found.descriptor < 0) return text_answer(404, "there is no such file below " + folder_);
    HttpAnswer answer;
    answer.type = type_of(path);
    answer.file = found.descriptor, answer.size = found.size;
    answer.headers.push_back(
        {"Content-Security-Policy",
         "sandbox allow-scripts allow-popups allow-downloads; default-src data: blob: 'unsafe-inline' "
         "'unsafe-eval'; form-action 'none'; frame-ancestors 'self'"});
    return answer;
  }

  const Options& options_;
  const std::string folder_, host_, token_;
  std::string cookie_;
  int port_ = 0;
  ServedRuns runs_;
  const runtime::Registry registry_;
};

}  // namespace

int serve(const Options& options) {
  const std::string host = options.host.empty() ? "127.0.0.1" : options.host;
  Site site(options, options.name.empty() ? "out" : options.name, host);
  HttpServer server(host, options.port);
  site.listens_on(server.port());
  const std::atomic<bool>& stop = stop_is_asked_for();
  std::printf("%s\n", site.address().c_str());
  if (host != "127.0.0.1" && host != "localhost" && host != "::1")
    std::fprintf(stderr, "warning: other machines reach this address; what they see goes over the network as it is\n");
  std::printf("Open it in a browser on this machine; Ctrl-C ends it\n");
  std::fflush(stdout);
  server.run([&](const HttpRequest& request) { return site.answer(request); }, stop);
  return 130;
}

}  // namespace plumbline::cli
