// What the writer helpers write reads back the same.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "building/ifc/ifc_guid.hpp"
#include "building/step/step.hpp"
#include "building/step/step_writer.hpp"

namespace plumbline {
namespace test_step_writer {

using namespace ifc;

step::Value read_back(const std::string& argument) {
  const step::File file(
      "ISO-10303-21;HEADER;ENDSEC;DATA;" + step::instance(5, "A", {argument}) + "ENDSEC;END-ISO-10303-21;", "t");
  return file.arguments(*file.find(5)).at(0);
}

TEST(StepWriter, RealsHaveAPointAndReadBackToTheBit) {
  EXPECT_EQ(step::real(0), "0.");
  EXPECT_EQ(step::real(-0.0), "0.");
  EXPECT_EQ(step::real(5), "5.");
  EXPECT_EQ(step::real(-1.25), "-1.25");
  EXPECT_EQ(step::real(1e-7), "1.E-07");
  EXPECT_EQ(step::real(1e300), "1.E+300");
  for (const double value : {0.1, 1.0 / 3, -2e-310, 1e22, 123456789.123456789, std::numeric_limits<double>::max()}) {
    const step::Value back = read_back(step::real(value));
    EXPECT_EQ(back.kind, step::Kind::real);
    if (std::abs(value) > 1e-300) {
      EXPECT_EQ(back.number, value);
    }
  }
  EXPECT_THROW(step::real(NAN), std::invalid_argument);
  EXPECT_THROW(step::real(INFINITY), std::invalid_argument);
}

TEST(StepWriter, RoundedRealsDropNoise) {
  EXPECT_EQ(step::real_rounded(0.1 + 0.2, 9), "0.3");
  EXPECT_EQ(step::real_rounded(-4e-12, 9), "0.");
  EXPECT_EQ(step::real_rounded(1200, 3), "1200.");
  EXPECT_EQ(step::real_rounded(-1.0005, 2), "-1.");
}

TEST(StepWriter, StringsSurviveTheRoundTrip) {
  EXPECT_EQ(step::text("it's C:\\x"), "'it''s C:\\\\x'");
  EXPECT_EQ(step::text("Stra\u00DFe"), "'Stra\\X2\\00DF\\X0\\e'");
  EXPECT_EQ(step::text("\u03A9\u03B1\U0001F600"), "'\\X2\\03A903B1\\X0\\\\X4\\0001F600\\X0\\'");
  for (const char* original : {"", "'", "\\", "\\X2\\", "a\u00E4\U0001F600z", "line\nbreak\ttab", "'';#1=("})
    EXPECT_EQ(read_back(step::text(original)).text, original);
}

TEST(StepWriter, ComposesInstances) {
  EXPECT_EQ(
      step::instance(7, "IFCX",
                     {step::null, step::derived, step::reference(3), step::list({step::integer(1), step::real(2)}),
                      step::enumeration("PASS"), step::boolean(true), step::typed("IFCLABEL", step::text("x"))}),
      "#7=IFCX($,*,#3,(1,2.),.PASS.,.T.,IFCLABEL('x'));");
}

TEST(IfcGuid, AgreesWithAKnownPairAndInverts) {
  const auto uuid = uuid_from_text("f70dd363-bfe3-495d-84a0-2c02dcb7d4d2");
  ASSERT_TRUE(uuid);
  EXPECT_EQ(ifc_guid(*uuid), "3t3TDZl_D9NOIWB0BSjzJI");
  EXPECT_EQ(uuid_from_ifc_guid("3t3TDZl_D9NOIWB0BSjzJI"), uuid);
  EXPECT_EQ(uuid_to_text(*uuid), "f70dd363-bfe3-495d-84a0-2c02dcb7d4d2");
  EXPECT_FALSE(uuid_from_ifc_guid("4t3TDZl_D9NOIWB0BSjzJI"));
  EXPECT_FALSE(uuid_from_ifc_guid("3t3TDZl-D9NOIWB0BSjzJI"));
  EXPECT_FALSE(uuid_from_text("f70dd363-bfe3-495d-84a0-2c02dcb7d4d"));
}

TEST(IfcGuid, Version5AgreesWithRfc4122) {
  // Name space DNS, "www.example.com": the value in the errata of RFC 4122 and in Python's documentation of uuid5.
  const auto dns = uuid_from_text("6ba7b810-9dad-11d1-80b4-00c04fd430c8");
  EXPECT_EQ(uuid_to_text(uuid_v5(*dns, "www.example.com")), "2ed6657d-e927-568b-95e1-2665a8aea6a2");
  EXPECT_EQ(uuid_to_text(uuid_v5(*dns, "python.org")), "886313e1-3b8a-5372-9b90-0c9aee199e5d");
}

TEST(IfcGuid, DerivedGuidsAreStableAndDiffer) {
  const std::string parent = "1CGyzxdzHtJybf9L4wHy3R";
  EXPECT_EQ(derived_ifc_guid(parent, "a"), derived_ifc_guid(parent, "a"));
  EXPECT_NE(derived_ifc_guid(parent, "a"), derived_ifc_guid(parent, "b"));
  EXPECT_NE(derived_ifc_guid("not a guid", "a"), derived_ifc_guid(parent, "a"));
  EXPECT_TRUE(uuid_from_ifc_guid(derived_ifc_guid("not a guid", "a")));
}

}  // namespace test_step_writer
}  // namespace plumbline
