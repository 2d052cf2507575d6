#include "loop/state/hash.hpp"

#include <openssl/evp.h>

#include <cmath>
#include <stdexcept>

namespace plumbline::loop {

std::string sha256_hex(std::string_view bytes) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("OpenSSL cannot compute SHA-256");
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (unsigned int i = 0; i < size; ++i) hex += kDigits[digest[i] >> 4], hex += kDigits[digest[i] & 15];
  return hex;
}

std::string sha256_hex(const std::vector<double>& numbers, double step) {
  std::string text;
  for (const double number : numbers)
    text += std::isnan(number) ? std::string("nan ") : std::to_string(std::llround(number / step)) + " ";
  return sha256_hex(text);
}

}  // namespace plumbline::loop
