// Ed25519 over the bytes of a file, in a file beside it, as `openssl pkeyutl -rawin` writes and checks it.
#pragma once

#include <string>

namespace plumbline::loop {

/// 64 bytes. `key`: a private key in PEM (openssl genpkey -algorithm ed25519). Throws std::runtime_error for any other
/// key.
std::string sign_bytes(const std::string& bytes, const std::string& key);

/// Empty if it holds; else why not. `key`: a public key in PEM.
std::string signature_fault(const std::string& bytes, const std::string& signature, const std::string& key);

}  // namespace plumbline::loop
