// What the documentation says is what the code does: the tables of doc/parameters.md, the list of
// matchers, the tests that doc/recordings.md names, the code that doc/matchers.md quotes, where
// links lead, the reports that figures are quoted from, and that the figures of tables are in
// these.
//
// After a change of options write the tables anew:
//   MATCHBOX_UPDATE_README=1 rosrun matchbox_slam test_documentation

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "ros/matcher_loader.hpp"
#include "run/cloud_options.hpp"
#include "run/run_options.hpp"
#include "run/scan_matcher_setup.hpp"
#include "run/slam_node_options.hpp"

namespace matchbox_slam {
namespace {

constexpr std::string_view kTableBegins =
    "<!-- parameters: generated, see test_documentation -->\n";
constexpr std::string_view kTableEnds = "<!-- end of parameters -->\n";

std::string in_package(const std::string& file) {
  return std::string(MATCHBOX_SOURCE_DIR) + "/" + file;
}

std::vector<std::string> own_matchers() {
  std::vector<std::string> names;
  for (const std::string& name : MatcherLoader().lookup_names()) {
    if (name.rfind("matchbox_slam/", 0) == 0) {
      names.push_back(name);
    }
  }
  return names;
}

/// README.md, CONTRIBUTING.md and the pages of doc/, as paths in the package.
std::vector<std::string> pages() {
  std::vector<std::string> files = {"README.md", "CONTRIBUTING.md"};
  for (const auto& entry : std::filesystem::directory_iterator(in_package("doc"))) {
    if (entry.path().extension() == ".md") {
      files.push_back("doc/" + entry.path().filename().string());
    }
  }
  return files;
}

constexpr std::string_view kReports = "benchmark/reports/current/";

/// Those that are there, as paths in the package.
std::vector<std::string> reports() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(in_package(std::string(kReports)))) {
    if (entry.path().extension() == ".md") {
      files.push_back(std::string(kReports) + entry.path().filename().string());
    }
  }
  return files;
}

/// Text between two markers, without them. Both have to be there.
std::string between_markers(const std::string& text, std::string_view begin, std::string_view end) {
  const std::size_t first = text.find(begin);
  const std::size_t last = text.find(end, first);
  if (first == std::string::npos || last == std::string::npos) {
    return "(no " + std::string(begin) + ")";
  }
  return text.substr(first + begin.size(), last - first - begin.size());
}

std::string rows_of(const std::string& section, const std::vector<OptionDescription>& options) {
  std::string text;
  for (const OptionDescription& option : options) {
    const std::string value = to_string(option.value);
    text += "| `" + section + option.name + "` | " + (value.empty() ? "" : "`" + value + "`") +
            " | " + option.unit + " | " + option.allowed + " | " + option.meaning + " |\n";
  }
  return text;
}

std::string table(const std::string& title, const std::string& rows) {
  return "\n## " + title +
         "\n\n| parameter | default | unit | allowed | meaning |\n|---|---|---|---|---|\n" + rows;
}

std::string parameter_tables() {
  std::string text = table("Run: node and `map_bag`", rows_of("", describe_options(RunOptions{})));
  text += table("Node only", rows_of("", describe_options(SlamNodeOptions{})));
  text += table("Engine", rows_of("", describe_engine_options(EngineOptions{})));
  text += table("Times of scans", rows_of("", describe_scan_timing_options({})));
  text += table("Clouds as scans", rows_of("", describe_cloud_options(CloudOptions{})));
  text += table("Laser odometry: `scan_matcher_node`",
                rows_of("", describe_options(ScanMatcherNodeOptions{})) +
                    rows_of("odometry/", describe_options(LaserOdometryOptions{})));
  const MatcherLoader loader;
  for (const std::string& name : own_matchers()) {
    const std::string short_name = matcher_short_name(name);
    const std::string rows = rows_of(short_name + "/", loader.create(name)->options());
    if (!rows.empty()) {
      text += table("Matcher `" + short_name + "`", rows);
    }
  }
  return text + "\n";
}

TEST(Parameters, AreThoseOfTheCode) {
  const std::string file = in_package("doc/parameters.md");
  const std::string page = read_file(file);
  const std::string found = between_markers(page, kTableBegins, kTableEnds);
  const std::string expected = parameter_tables();
  if (std::getenv("MATCHBOX_UPDATE_README") != nullptr && found != expected) {
    std::string updated = page;
    updated.replace(updated.find(kTableBegins) + kTableBegins.size(), found.size(), expected);
    replace_file(file, updated);
    GTEST_SKIP() << file << " is updated";
  }
  EXPECT_EQ(found, expected)
      << "to update: MATCHBOX_UPDATE_README=1 rosrun matchbox_slam test_documentation";
}

TEST(Matchers, AreEachInTheTableOfTheirPage) {
  const std::string page = read_file(in_package("doc/matchers.md"));
  for (const std::string& name : own_matchers()) {
    EXPECT_TRUE(contains(page, "\n| `" + matcher_short_name(name) + "`")) << name;
  }
}

TEST(Readme, IsReadInFiveMinutes) {
  std::istringstream readme(read_file(in_package("README.md")));
  const auto words = std::distance(std::istream_iterator<std::string>(readme),
                                   std::istream_iterator<std::string>());
  EXPECT_LE(words, 1100) << "what is not needed first belongs on a page in doc/";
}

TEST(Pages, AreTen) {
  const std::vector<std::string> all = pages();
  EXPECT_EQ(std::count_if(all.begin(), all.end(),
                          [](const std::string& page) { return page.rfind("doc/", 0) == 0; }),
            10)
      << "what is new belongs on one of those that there are";
}

TEST(Readme, LeadsToEveryPage) {
  const std::string readme = read_file(in_package("README.md"));
  for (const std::string& page : pages()) {
    EXPECT_TRUE(page == "README.md" || contains(readme, "](" + page + ")")) << page;
  }
}

TEST(Pages, NameWhatIsShipped) {
  std::string text;
  for (const std::string& page : pages()) {
    text += read_file(in_package(page));
  }
  for (const std::string folder : {"launch", "msg", "srv"}) {
    for (const auto& entry : std::filesystem::directory_iterator(in_package(folder))) {
      const std::filesystem::path& file = entry.path();
      const std::string name =
          folder == "launch" ? file.filename().string() : "matchbox_slam/" + file.stem().string();
      EXPECT_TRUE(contains(text, name)) << file << " is on no page";
    }
  }
}

TEST(Pages, UseToolsOfRosThatPackageXmlNames) {
  std::string text;
  for (const std::string& page : pages()) {
    text += read_file(in_package(page));
  }
  const std::string package = read_file(in_package("package.xml"));
  int used = 0;
  for (const std::string tool :
       {"rosbag", "roslaunch", "rosnode", "rosparam", "rosservice", "rostopic"}) {
    if (std::regex_search(text, std::regex("(^|[`\n ])" + tool + " [a-z_]+ [/a-z]"))) {
      ++used;
      EXPECT_TRUE(contains(package, "depend>" + tool + "<")) << tool;
    }
  }
  EXPECT_GE(used, 2);
}

TEST(LaunchFiles, CallNoArgumentRequiredThatIsNot) {
  for (const auto& entry : std::filesystem::directory_iterator(in_package("launch"))) {
    EXPECT_FALSE(contains(read_file(entry.path().string()), "default=\"\""))
        << entry.path() << ": roslaunch --ros-args takes an empty default for none";
  }
}

/// A page without its code, in which brackets are no links.
std::string without_code(const std::string& page) {
  return std::regex_replace(page, std::regex(R"(```[^]*?```|`[^`\n]*`)"), "");
}

/// The names by which links reach the headings of a page: lower case, `-` for blanks, without
/// punctuation.
std::set<std::string> anchors(const std::string& page) {
  std::set<std::string> names;
  const std::regex heading(R"((?:^|\n)#+ ([^\n]+))");  // GCC 10 knows no regex::multiline
  const std::string text = std::regex_replace(page, std::regex(R"(```[^]*?```)"), "");
  for (std::sregex_iterator at(text.begin(), text.end(), heading); at != std::sregex_iterator();
       ++at) {
    std::string name;
    for (const char letter : at->str(1)) {
      const auto code = static_cast<unsigned char>(letter);
      if (letter == ' ') {
        name += '-';
      } else if (std::isalnum(code) != 0 || letter == '-' || letter == '_' || code >= 0x80) {
        name += static_cast<char>(std::tolower(code));
      }
    }
    names.insert(name);
  }
  return names;
}

/// The number of links, each of which leads somewhere.
int check_links(const std::vector<std::string>& files) {
  int links = 0;
  for (const std::string& page : files) {
    const std::string text = without_code(read_file(in_package(page)));
    const std::regex link(R"re((?:\]\(|src=")([^)#\s"]*)(?:#([^)\s"]*))?[)"])re");
    for (std::sregex_iterator at(text.begin(), text.end(), link); at != std::sregex_iterator();
         ++at, ++links) {
      const std::string path = at->str(1);
      if (path.rfind("http", 0) == 0) {
        continue;
      }
      const std::filesystem::path here = in_package(page);
      const std::filesystem::path file = path.empty() ? here : here.parent_path() / path;
      EXPECT_TRUE(std::filesystem::exists(file)) << page << " leads to " << at->str();
      if ((*at)[2].matched && std::filesystem::exists(file)) {
        EXPECT_EQ(anchors(read_file(file.string())).count(at->str(2)), 1U)
            << page << " leads to " << at->str();
      }
    }
  }
  return links;
}

TEST(Pages, HaveLinksThatLeadSomewhere) { EXPECT_GT(check_links(pages()), 60); }

TEST(Reports, HaveLinksThatLeadSomewhere) { EXPECT_GT(check_links(reports()), 20); }

TEST(Reports, AreEachInTheIndex) {
  const std::string index = read_file(in_package(std::string(kReports) + "README.md"));
  for (const std::string& report : reports()) {
    const std::string name = std::filesystem::path(report).filename().string();
    EXPECT_TRUE(name == "README.md" || contains(index, "](" + name + ")")) << report;
  }
}

/// What may quote a report: pages, the changelog, sources, and the programs that make reports.
std::vector<std::string> files_with_quotes() {
  std::vector<std::string> files = pages();
  files.emplace_back("CHANGELOG.rst");
  const std::set<std::string> kinds = {".cpp", ".hpp", ".py", ".yaml"};
  for (const std::string folder : {"src", "include", "config", "test", "benchmark"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(
             in_package(folder), std::filesystem::directory_options::follow_directory_symlink)) {
      if (kinds.count(entry.path().extension().string()) == 1) {
        files.push_back(std::filesystem::relative(entry.path(), in_package("")).generic_string());
      }
    }
  }
  return files;
}

/// `benchmark/reports/...` and `NAME.md`, but for programs and tests, which tell so what they
/// write.
std::vector<std::string> quoted_reports(const std::string& file, const std::string& text) {
  std::vector<std::string> found;
  const std::regex path(R"(benchmark/reports/[\w/.-]*\w\.(?:md|json|png))");
  for (std::sregex_iterator at(text.begin(), text.end(), path); at != std::sregex_iterator();
       ++at) {
    found.push_back(at->str());
  }
  if (file.rfind("benchmark/", 0) == 0 || file.rfind("test/", 0) == 0) {
    return found;
  }
  const std::regex bare(R"((^|[^\w/.-])([A-Z][A-Z_]{2,}\.md))");
  for (std::sregex_iterator at(text.begin(), text.end(), bare); at != std::sregex_iterator();
       ++at) {
    const std::string name = at->str(2);
    if (!std::filesystem::exists(in_package(name))) {  // as README.md
      found.push_back(std::string(kReports) + name);
    }
  }
  return found;
}

TEST(Reports, ThatAreQuotedAreThere) {
  EXPECT_EQ(quoted_reports("src/a.cpp", "// (benchmark/reports/1999-01-01/OLD.md), NONE.md"),
            (std::vector<std::string>{"benchmark/reports/1999-01-01/OLD.md",
                                      "benchmark/reports/current/NONE.md"}));
  int quotes = 0;
  for (const std::string& file : files_with_quotes()) {
    if (file == "test/documentation/test_documentation.cpp") {
      continue;  // whose examples are of none
    }
    for (const std::string& report : quoted_reports(file, read_file(in_package(file)))) {
      ++quotes;
      EXPECT_TRUE(std::filesystem::exists(in_package(report))) << file << " quotes " << report;
    }
  }
  EXPECT_GT(quotes, 60);
}

struct Figure {
  double value = 0.0;
  double half_a_digit = 0.0;  ///< of the last digit that is written
};

/// The numbers of a text but for those within words, such as `lds01`.
std::vector<Figure> figures_in(const std::string& text) {
  const std::regex number(R"((^|[^\w.,])(\d[\d,]*(?:\.(\d+))?)(?![\w]))");
  std::vector<Figure> found;
  for (std::sregex_iterator at(text.begin(), text.end(), number); at != std::sregex_iterator();
       ++at) {
    std::string digits = at->str(2);
    digits.erase(std::remove(digits.begin(), digits.end(), ','), digits.end());
    found.push_back(
        {std::stod(digits), 0.5 * std::pow(10.0, -static_cast<double>((*at)[3].length()))});
  }
  return found;
}

/// Whether the figure, as it is rounded, is one of the numbers of the text, which has at least as
/// many digits.
bool is_told(const Figure& figure, const std::string& text) {
  constexpr double kRounding = 1.0 + 1e-6;
  const std::vector<Figure> told = figures_in(text);
  return std::any_of(told.begin(), told.end(), [&](const Figure& one) {
    return std::abs(one.value - figure.value) <= kRounding * figure.half_a_digit &&
           one.half_a_digit <= kRounding * figure.half_a_digit;
  });
}

/// The rows of a report's tables; what it says in between is not what was measured.
std::string rows_of(const std::string& report) {
  std::string rows;
  std::istringstream lines(report);
  for (std::string line; std::getline(lines, line);) {
    rows += line.rfind('|', 0) == 0 ? line + "\n" : "";
  }
  return rows;
}

/// The lines of a text that have the name, but not as a part of a longer one.
std::string lines_with(const std::string& name, const std::string& text) {
  std::string found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    for (std::size_t at = line.find(name); at != std::string::npos; at = line.find(name, at + 1)) {
      const auto is_of_word = [&](std::size_t place) {
        return place < line.size() &&
               (std::isalnum(static_cast<unsigned char>(line[place])) != 0 || line[place] == '_');
      };
      if (!is_of_word(at + name.size()) && (at == 0 || !is_of_word(at - 1))) {
        found += line + "\n";
        break;
      }
    }
  }
  return found;
}

/// What of a page's tables is in no table of the reports that the line before a table names, as
/// `<!-- figures: A.md B.md -->`, or with `figures by name` in no line of these with what the
/// row's first cell has in backticks. A table without such a line counts as a whole.
std::vector<std::string> figures_of_no_report(const std::string& page) {
  const std::regex source(R"(<!-- figures( by name)?: (.*) -->)");
  const std::regex name(R"(^\| `([^`]+)`)");
  std::vector<std::string> missing;
  std::string text;
  std::smatch named;
  bool is_by_name = false;
  bool is_in_table = false;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_match(line, named, source)) {
      is_by_name = named[1].matched;
      text.clear();
      std::istringstream files(named.str(2));
      for (std::string file; files >> file;) {
        text += rows_of(read_file(in_package(std::string(kReports) + file)));
      }
    } else if (line.rfind("| ", 0) == 0 && !is_in_table) {
      is_in_table = true;  // by its heading, whose numbers are none that were measured
    } else if (line.rfind("| ", 0) == 0) {
      const bool has_name = is_by_name && std::regex_search(line, named, name);
      const std::string& told = has_name ? lines_with(named.str(1), text) : text;
      const std::string cells = line.substr(line.find(" | "));
      for (const Figure& figure : figures_in(cells)) {
        if (!is_told(figure, told)) {
          missing.push_back(std::to_string(figure.value) + " of " + line);
        }
      }
    } else if (line.rfind('|', 0) != 0) {
      is_in_table = false;
      text = line.empty() || line.rfind("<!--", 0) == 0 ? text : "";
    }
  }
  return missing;
}

TEST(Reports, HaveEachFigureOfTheTablesOfResults) {
  const std::string by_name = "<!-- figures by name: COMMON_GROUND.md -->\n| a | b |\n|---|---|\n";
  EXPECT_TRUE(figures_of_no_report(by_name + "| `csail`: 2 halls | 0.124 |\n").empty());
  EXPECT_EQ(figures_of_no_report(by_name + "| `csail` | 0.125 |\n").size(), 1U);
  EXPECT_EQ(figures_of_no_report(by_name + "| `csail` | 0.10040 |\n").size(), 1U);
  EXPECT_EQ(figures_of_no_report(by_name + "| `aces` | 0.124 |\n").size(), 1U);
  EXPECT_EQ(figures_of_no_report("| a | b |\n|---|---|\n| `csail` | 0.124 |\n").size(), 1U);
  for (const std::string page : {"README.md", "doc/results.md"}) {
    for (const std::string& missing : figures_of_no_report(read_file(in_package(page)))) {
      ADD_FAILURE() << page << ": in no report that the table names: " << missing;
    }
  }
}

/// The titles of a file's sections, which are underlined by dashes: "1.0.0 (2026-11-23)".
std::vector<std::string> underlined_titles(const std::string& text) {
  std::vector<std::string> titles;
  std::istringstream lines(text);
  std::string before;
  for (std::string line; std::getline(lines, line); before = line) {
    if (!before.empty() && line == std::string(before.size(), '-')) {
      titles.push_back(before);
    }
  }
  return titles;
}

TEST(Changelog, HasForthcomingChangesAboveTheVersionOfThePackage) {
  const std::string package = read_file(in_package("package.xml"));
  const std::string version = between_markers(package, "<version>", "</version>");
  std::vector<std::string> titles = underlined_titles(read_file(in_package("CHANGELOG.rst")));
  ASSERT_FALSE(titles.empty());
  if (titles.front() == "Forthcoming") {  // not at a release itself
    titles.erase(titles.begin());
  }
  ASSERT_FALSE(titles.empty());
  EXPECT_EQ(titles.front().rfind(version + " (", 0), 0U) << titles.front();
  EXPECT_TRUE(contains(read_file(in_package("CITATION.cff")), "\nversion: " + version + "\n"));
}

/// Names of all tests, as Suite.Name.
std::set<std::string> names_of_tests() {
  const std::regex definition(R"(TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\))");
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(in_package("test"))) {
    if (entry.path().extension() != ".cpp") {
      continue;
    }
    const std::string source = read_file(entry.path().string());
    for (std::sregex_iterator at(source.begin(), source.end(), definition);
         at != std::sregex_iterator(); ++at) {
      names.insert(at->str(1) + "." + at->str(2));
    }
  }
  return names;
}

TEST(BadInput, NamesATestThatThereIsInEveryRow) {
  const std::set<std::string> tests = names_of_tests();
  const std::string page = read_file(in_package("doc/recordings.md"));
  std::istringstream section(page.substr(page.find("\n## Bad input\n")));
  const std::regex named(R"(`(\w+\.\w+)`)");
  int rows = 0;
  for (std::string row; std::getline(section, row);) {
    if (row.rfind("| ", 0) != 0 || row == "| input | what happens | test |") {
      continue;
    }
    ++rows;
    const std::string last_cell = row.substr(row.rfind(" | ") + 1);
    std::sregex_iterator name(last_cell.begin(), last_cell.end(), named);
    EXPECT_TRUE(name != std::sregex_iterator()) << "no test is named: " << row;
    for (; name != std::sregex_iterator(); ++name) {
      EXPECT_EQ(tests.count(name->str(1)), 1U) << name->str(1);
    }
  }
  EXPECT_GT(rows, 70);
}

struct Quotation {
  std::string file;
  std::string text;
};

/// Code blocks that follow a line `<!-- from FILE -->`.
std::vector<Quotation> quotations(const std::string& document) {
  const std::string begin = "<!-- from ";
  std::vector<Quotation> found;
  for (std::size_t at = document.find(begin); at != std::string::npos;
       at = document.find(begin, at + 1)) {
    const std::size_t name = at + begin.size();
    const std::size_t block = document.find('\n', document.find("```", name)) + 1;
    found.push_back({document.substr(name, document.find(" -->", name) - name),
                     document.substr(block, document.find("```", block) - block)});
  }
  return found;
}

TEST(Guide, QuotesTheExampleAsItIs) {
  const std::vector<Quotation> all = quotations(read_file(in_package("doc/matchers.md")));
  EXPECT_GE(all.size(), 5U);
  for (const auto& [file, text] : all) {
    EXPECT_FALSE(text.empty()) << file;
    EXPECT_TRUE(contains(read_file(in_package(file)), text)) << file << " does not contain:\n"
                                                             << text;
  }
}

}  // namespace
}  // namespace matchbox_slam
