// A small HTTP server for pages on this machine: GET and HEAD, one answer a connection, nothing kept.
//
// Whatever comes is bounded: the head of a request in bytes and in time from its first byte, an answer in time without
// progress, the number of connections (the oldest one goes when another comes). The libraries at hand bound neither the
// head nor its time.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace plumbline::cli {

struct HttpRequest {
  std::string path;                            ///< percent-decoded, without the query; begins with '/'
  std::map<std::string, std::string> query;    ///< decoded
  std::map<std::string, std::string> headers;  ///< by names in small letters; one that stands twice is refused
};

struct HttpAnswer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
  int file = -1;  ///< if not -1, its content in place of `body`; closed by the server
  std::uint64_t size = 0;
  std::vector<std::pair<std::string, std::string>> headers;
};

/// The request of a head such as "GET /a?b=c HTTP/1.1\r\nHost: x\r\n\r\n". False with the status to answer if it is
/// none.
bool parse_request(const std::string& head, HttpRequest& request, int& status);

/// "%41b" -> "Ab"; false for half an escape or a NUL. `plus` reads '+' as a blank, as in queries.
bool percent_decoded(const std::string& text, bool plus, std::string& decoded);

class HttpServer {
 public:
  using Handler = std::function<HttpAnswer(const HttpRequest&)>;

  /// Listens at once. `host` is an address or a name that stands for one; port 0: any that is free. Throws
  /// std::runtime_error.
  HttpServer(const std::string& host, int port);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const { return port_; }
  /// Answers until `stop`; `handler` is called from several threads and what it throws is answered with 500.
  void run(const Handler& handler, const std::atomic<bool>& stop);

 private:
  int socket_ = -1, port_ = 0;
};

}  // namespace plumbline::cli
