#include "loop/job/signature.hpp"

#include <openssl/evp.h>
#include <openssl/pem.h>

#include <memory>
#include <stdexcept>

namespace plumbline::loop {
namespace {

using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using Memory = std::unique_ptr<BIO, decltype(&BIO_free)>;
using Digest = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;

Key read_key(const std::string& pem, bool is_private) {
  const Memory memory(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free);
  Key key(is_private ? PEM_read_bio_PrivateKey(memory.get(), nullptr, nullptr, nullptr)
                     : PEM_read_bio_PUBKEY(memory.get(), nullptr, nullptr, nullptr),
          EVP_PKEY_free);
  if (!key || EVP_PKEY_id(key.get()) != EVP_PKEY_ED25519) return Key(nullptr, EVP_PKEY_free);
  return key;
}

const unsigned char* raw(const std::string& text) { return reinterpret_cast<const unsigned char*>(text.data()); }

}  // namespace

std::string sign_bytes(const std::string& bytes, const std::string& pem) {
  const Key key = read_key(pem, true);
  if (!key)
    throw std::runtime_error(
        "the signing key is no Ed25519 private key in PEM; make one with 'openssl genpkey -algorithm ed25519 -out "
        "key.pem'");
  const Digest digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  std::string signature(64, '\0');
  std::size_t size = signature.size();
  if (EVP_DigestSignInit(digest.get(), nullptr, nullptr, nullptr, key.get()) != 1 ||
      EVP_DigestSign(digest.get(), reinterpret_cast<unsigned char*>(signature.data()), &size, raw(bytes),
                     bytes.size()) != 1)
    throw std::runtime_error("OpenSSL could not sign");
  return signature;
}

std::string signature_fault(const std::string& bytes, const std::string& signature, const std::string& pem) {
  const Key key = read_key(pem, false);
  if (!key) return "the key to check the signature with is no Ed25519 public key in PEM";
  if (signature.empty()) return "the job carries no signature";
  if (signature.size() != 64) return "the signature has " + std::to_string(signature.size()) + " bytes, Ed25519 has 64";
  const Digest digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  if (EVP_DigestVerifyInit(digest.get(), nullptr, nullptr, nullptr, key.get()) != 1)
    return "OpenSSL could not check the signature";
  if (EVP_DigestVerify(digest.get(), raw(signature), signature.size(), raw(bytes), bytes.size()) != 1)
    return "the signature is not that of these bytes by this key: the job was changed, or somebody else made it";
  return {};
}

}  // namespace plumbline::loop
