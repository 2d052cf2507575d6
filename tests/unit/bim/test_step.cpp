// The Part 21 reader on what the standard allows, on what exporters write, and on damage.
#include <algorithm>
#include <cstdint>
#include <set>

#include "building/step/step.hpp"
#include "test_support.hpp"

namespace plumbline::step {
namespace test_step {

std::string file_with(const std::string& data) {
  return "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('n','',(''),(''),'','','');\n"
         "FILE_SCHEMA(('Ifc4'));\nENDSEC;\nDATA;\n" +
         data + "\nENDSEC;\nEND-ISO-10303-21;\n";
}

std::vector<Value> arguments_of(const std::string& list) {
  const File file(file_with("#1=A" + list + ";"), "t.ifc");
  return file.arguments(*file.find(1));
}

std::string text_of(const std::string& quoted) { return arguments_of("(" + quoted + ")").at(0).text; }

std::string message_of(const std::string& bytes) {
  try {
    const File file(bytes, "t.ifc");
    for (const Instance& instance : file.instances()) file.records(instance);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(StepReader, ReadsEveryKindOfArgument) {
  const auto v = arguments_of("($,*,-12,1.5E-3,'it''s',.ELEMENT.,#77,(1.,(2,3)),IFCLABEL('x'),\"1F\",+2.,.T.)");
  ASSERT_EQ(v.size(), 12u);
  EXPECT_EQ(v[0].kind, Kind::null);
  EXPECT_EQ(v[1].kind, Kind::derived);
  EXPECT_EQ(v[2].kind, Kind::integer);
  EXPECT_EQ(v[2].number, -12);
  EXPECT_EQ(v[3].kind, Kind::real);
  EXPECT_EQ(v[3].number, 1.5e-3);
  EXPECT_EQ(v[4].text, "it's");
  EXPECT_EQ(v[5].text, "ELEMENT");
  EXPECT_EQ(v[6].id, 77u);
  EXPECT_EQ(v[7].items.at(1).items.at(1).number, 3);
  EXPECT_EQ(v[8].text, "IFCLABEL");
  EXPECT_EQ(v[8].items.at(0).text, "x");
  EXPECT_EQ(v[9].text, "1F");
  EXPECT_EQ(v[10].number, 2);
  EXPECT_EQ(v[11].text, "T");
}

TEST(StepReader, RealsKeepAllTheirDigits) {
  const auto v =
      arguments_of("(1.E-5,0.1,1.7976931348623157E308,-3.14159265358979323846,1.E-400,7,1.00000000000000000E-5)");
  EXPECT_EQ(v[0].number, 1e-5);
  EXPECT_EQ(v[1].number, 0.1);
  EXPECT_EQ(v[2].number, 1.7976931348623157e308);
  EXPECT_EQ(v[3].number, -3.14159265358979323846);
  EXPECT_EQ(v[4].number, 0);
  EXPECT_EQ(v[5].number, 7);
  EXPECT_EQ(v[6].number, 1e-5);
  EXPECT_NE(message_of(file_with("#1=A(1.E999);")).find("t.ifc:8:6: found '1.E999'"), std::string::npos);
}

TEST(StepReader, AnArgumentThatIsLeftOutReadsLikeNone) {
  const File file(file_with("#1=A(,1.,(2.,),);#2=A();"), "t.ifc");
  const auto values = file.arguments(*file.find(1));
  ASSERT_EQ(values.size(), 4u);
  EXPECT_EQ(values[0].kind, Kind::null);
  EXPECT_EQ(values[1].number, 1);
  ASSERT_EQ(values[2].items.size(), 2u);
  EXPECT_EQ(values[2].items[1].kind, Kind::null);
  EXPECT_EQ(values[3].kind, Kind::null);
  EXPECT_TRUE(file.arguments(*file.find(2)).empty());
}

TEST(StepReader, DecodesStrings) {
  EXPECT_EQ(text_of("'Stra\\X2\\00DF\\X0\\e'"), "Stra\u00DFe");
  EXPECT_EQ(text_of("'\\X2\\03A903B1\\X0\\'"), "\u03A9\u03B1");
  EXPECT_EQ(text_of("'\\X2\\D83DDE00\\X0\\'"), "\U0001F600");  // a pair of surrogates, as some exporters write it
  EXPECT_EQ(text_of("'\\X4\\0001F600\\X0\\'"), "\U0001F600");
  EXPECT_EQ(text_of("'\\X\\E4'"), "\u00E4");
  EXPECT_EQ(text_of("'\\S\\d'"), "\u00E4");
  EXPECT_EQ(text_of("'\\PA\\x'"), "x");
  EXPECT_EQ(text_of("'\\S\\' 34'"), "\u00A7 34");  // its character may be an apostrophe,
  EXPECT_EQ(text_of("'(\\S\\'\\S\\')'"), "(\u00A7\u00A7)");
  EXPECT_EQ(text_of("'\\S\\'' 34'"), "\u00A7 34");  // which some exporters double
  EXPECT_EQ(text_of("'at \\S\\''"), "at \u00A7");
  EXPECT_EQ(text_of("'D:\\\\S\\\\'"), "D:\\S\\");  // and solidi of the text are none of it
  EXPECT_EQ(text_of("'a\\\\b'"), "a\\b");
  EXPECT_EQ(text_of("'C:\\Temp\\'"), "C:\\Temp\\");  // a solidus that was not escaped
  EXPECT_EQ(text_of("'\\X2\\00D'"), "\\X2\\00D");    // a directive cut off
  EXPECT_EQ(text_of("'two\r\nlines'"), "twolines");
  EXPECT_EQ(text_of("'\xC3\xA4\xE4'"), "\u00E4\u00E4");  // UTF-8 and Latin-1 bytes as they stand
  EXPECT_EQ(text_of("''"), "");
  EXPECT_EQ(text_of("''''"), "'");
}

TEST(StepReader, TakesBlanksCommentsLineBreaksAndSmallLetters) {
  const File file(file_with("#1 = ifcWall ( 1 ,\n  'a;b)' /* ); ' */\n , .t. ) ;#2=IFCWALL(2)/* between */;\n/* ** / "
                            "*/ #18446744073709551615=B();"),
                  "t.ifc");
  ASSERT_EQ(file.instances().size(), 3u);
  EXPECT_EQ(file.of_type("IFCWALL").size(), 2u);
  EXPECT_EQ(file.arguments(*file.find(1)).at(1).text, "a;b)");
  EXPECT_EQ(file.arguments(*file.find(1)).at(2).text, "T");
  EXPECT_EQ(file.largest_id(), UINT64_MAX);
  EXPECT_TRUE(file.arguments(*file.find(UINT64_MAX)).empty());
  EXPECT_FALSE(file.find(3));
  EXPECT_EQ(file.schemas(), std::vector<std::string>{"IFC4"});
  EXPECT_EQ(file.bytes().substr(file.data_end(), 7), "ENDSEC;");
}

TEST(StepReader, AFreeNumberIsAlsoAboveReferencesToNothing) {
  const auto free_in = [](const std::string& lines) { return File(file_with(lines), "t.ifc").free_id(); };
  EXPECT_EQ(free_in("#1=A();#5=A(#1);"), 6u);
  EXPECT_EQ(free_in("#1=A((#2,#7),#1);#6=A(#3);"), 8u);
  // Texts and comments refer to nothing.
  EXPECT_EQ(free_in("#1=A('#70 #8',\"0\",/* #60 */#2,.T.);/* #50 */#3=A('#4''#9');"), 4u);
  EXPECT_EQ(free_in("#2=A(#99999999999999999999);#1=A('#7');"), 3u);
  EXPECT_EQ(free_in("#1=A(#18446744073709551615);"), 0u);
}

TEST(StepReader, FindsEveryNumberWhateverTheirOrderAndGaps) {
  std::uint64_t state = 1;
  const auto random = [&state](std::uint64_t below) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return (state >> 33) % below;
  };
  for (const std::uint64_t gap : {1u, 2u, 40u, 1000u})
    for (const bool shuffled : {false, true}) {
      std::vector<std::uint64_t> numbers{1 + random(50)};
      while (numbers.size() < 300) numbers.push_back(numbers.back() + 1 + random(gap));
      const std::set<std::uint64_t> all(numbers.begin(), numbers.end());
      if (shuffled)
        for (std::size_t i = numbers.size() - 1; i > 0; --i) std::swap(numbers[i], numbers[random(i + 1)]);
      std::string lines;
      for (const std::uint64_t number : numbers) lines += "#" + std::to_string(number) + "=A();";
      const File file(file_with(lines), "t.ifc");
      EXPECT_EQ(file.largest_id(), *all.rbegin());
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        EXPECT_EQ(file.instances()[i].id, numbers[i]);
        ASSERT_TRUE(file.find(numbers[i])) << numbers[i];
        EXPECT_EQ(file.find(numbers[i])->index, i);
      }
      for (std::uint64_t number = 0; number < *all.rbegin() + 50; ++number)
        EXPECT_EQ(file.find(number).has_value(), all.contains(number)) << number;
    }
}

TEST(StepReader, ReadsComplexInstancesAndEdition3Sections) {
  const File file(
      "ISO-10303-21;HEADER;FILE_SCHEMA(('X'));ENDSEC;ANCHOR;<a>=#1;ENDSEC;DATA('d',('X'));#1=(A(1)B($,'x'));ENDSEC;END-"
      "ISO-10303-21;",
      "t.ifc");
  const auto parts = file.records(*file.find(1));
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[1].keyword, "B");
  EXPECT_EQ(parts[1].arguments.at(1).text, "x");
  EXPECT_THROW(file.arguments(*file.find(1)), Error);
}

TEST(StepReader, ErrorsNamePlaceFoundAndExpected) {
  EXPECT_EQ(message_of(file_with("#1=A(1 2);")), "t.ifc:8:8: found '2', expected ',' or ')' after an argument");
  EXPECT_EQ(message_of(file_with("#1 A(1);")), "t.ifc:8:4: found 'A', expected '=' after the number of the instance");
  EXPECT_EQ(message_of(file_with("#1=A(1;")),
            "t.ifc:8:7: found ';', expected ')' that closes the arguments opened at t.ifc:8:5");
  EXPECT_EQ(message_of(file_with("#1=A(1)")), "t.ifc:9:1: found 'E', expected ';' at the end of #1");
  EXPECT_EQ(message_of(file_with("#1=A(@);")), "t.ifc:8:6: found '@', expected an argument");
  EXPECT_EQ(message_of(file_with("#1=A(1);\n#1=B(2);")),
            "t.ifc:9:1: found #1 a second time, expected every number once; the first is at t.ifc:8:1");
  EXPECT_EQ(message_of(file_with("/* x")), "t.ifc:8:1: found a comment that is never closed, expected '*/'");
  EXPECT_EQ(message_of(""),
            "t.ifc:1:1: found the end of the file, expected 'ISO-10303-21;' at the start of a STEP file");
  EXPECT_NE(message_of("PK\x03\x04").find("ZIP archive is cut off"), std::string::npos);
  EXPECT_NE(message_of("<?xml").find("found XML that is damaged"), std::string::npos);
  EXPECT_NE(message_of("ISO-10303-21;HEADER;ENDSEC;DATA;#1=A();").find("cut off"), std::string::npos);
}

TEST(StepReader, DeepNestingIsAnErrorAndNoStackOverflow) {
  EXPECT_NE(
      message_of(file_with("#1=A" + std::string(200000, '(') + std::string(200000, ')') + ";")).find("nested deeper"),
      std::string::npos);
  EXPECT_NE(message_of("ISO-10303-21;HEADER;A" + std::string(200000, '(')).find("nested deeper"), std::string::npos);
  EXPECT_EQ(message_of(file_with("#1=A" + std::string(90, '(') + std::string(90, ')') + ";")), "no error");
}

TEST(StepReader, EveryTruncationIsAnError) {
  const std::string whole =
      file_with("#1=IFCX('a''b',(1.5E-3,#2),.T.,IFCLABEL('\\X2\\00DF\\X0\\'),$,*);/* c */\n#2=(A(1)B(\"0F\"));");
  ASSERT_EQ(message_of(whole), "no error");
  for (std::size_t length = 0; length + 2 <= whole.size(); ++length)  // the last line end may go
    EXPECT_NE(message_of(whole.substr(0, length)), "no error") << length;
}

TEST(StepReader, RandomDamageNeverCrashes) {
  const std::string whole = file_with(
      "#1=IFCX('a''b',(1.5E-3,#2),.T.,IFCLABEL('\\X2\\00DF\\X0\\\\S\\d\\X\\E4'),$,*);/* c */\n#2=(A(1)B(\"0F\"));");
  std::uint64_t state = 1;
  const auto next = [&state] {  // splitmix64
    std::uint64_t z = state += 0x9E3779B97F4A7C15;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return z ^ (z >> 31);
  };
  const std::string spice = "()'\"/*;#=.\\X2S0$,E-+\n\xFF";
  int accepted = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    std::string damaged = whole;
    for (std::uint64_t change = 0; change <= next() % 4; ++change) {
      const std::size_t at = next() % damaged.size();
      switch (next() % 3) {
        case 0:
          damaged[at] = spice[next() % spice.size()];
          break;
        case 1:
          damaged.erase(at, 1 + next() % 5);
          break;
        default:
          damaged.insert(at, 1, spice[next() % spice.size()]);
      }
    }
    accepted += message_of(damaged) == "no error";
  }
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, 20000);
}

TEST(StepReader, ReadsRealFiles) {
  for (const auto& [name, instances] :
       {std::pair{"510--curtainWall.ifc", 217u}, std::pair{"TallBuilding.ifc", 0u},
        std::pair{"Ifc4_SampleHouse.ifc", 0u}, std::pair{"tested_sample_project_2x3.ifc", 0u}}) {
    PLUMBLINE_REQUIRE_DATA(std::string("ifc/") + name);
    const std::string bytes = test::read_file(test::data_file(std::string("ifc/") + name));
    const File file(bytes, name);
    // Independent count: every instance of these files starts a line.
    std::size_t lines = bytes[0] == '#';
    for (std::size_t i = 1; i < bytes.size(); ++i) lines += bytes[i] == '#' && bytes[i - 1] == '\n';
    EXPECT_EQ(file.instances().size(), lines) << name;
    if (instances) {
      EXPECT_EQ(file.instances().size(), instances);
    }
    for (const Instance& instance : file.instances()) EXPECT_NO_THROW(file.arguments(instance)) << name;
  }
}

}  // namespace test_step
}  // namespace plumbline::step
