// Signatures of jobs.
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/pem.h>

#include "loop/job/signature.hpp"

namespace plumbline::loop {
namespace test_signature {

std::string pem(EVP_PKEY* key, bool is_private) {
  BIO* memory = BIO_new(BIO_s_mem());
  if (is_private)
    PEM_write_bio_PrivateKey(memory, key, nullptr, nullptr, 0, nullptr, nullptr);
  else
    PEM_write_bio_PUBKEY(memory, key);
  char* data = nullptr;
  const long size = BIO_get_mem_data(memory, &data);
  std::string text(data, static_cast<std::size_t>(size));
  BIO_free(memory);
  return text;
}

TEST(Signature, HoldsForTheseBytesAndThisKeyOnly) {
  EVP_PKEY* key = EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519");
  EVP_PKEY* other = EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519");
  const std::string job = "{\"jobId\": \"job-1\"}", signature = sign_bytes(job, pem(key, true));
  EXPECT_EQ(signature_fault(job, signature, pem(key, false)), "");
  EXPECT_NE(signature_fault(job + " ", signature, pem(key, false)).find("the job was changed"), std::string::npos);
  EXPECT_NE(signature_fault(job, signature, pem(other, false)), "");
  EXPECT_NE(signature_fault(job, "", pem(key, false)).find("carries no signature"), std::string::npos);
  EXPECT_NE(signature_fault(job, signature.substr(1), pem(key, false)).find("has 63 bytes"), std::string::npos);
  EXPECT_THROW(sign_bytes(job, pem(key, false)), std::runtime_error);
  EVP_PKEY_free(key), EVP_PKEY_free(other);
}

}  // namespace test_signature
}  // namespace plumbline::loop
