// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/stroke_font.h"

#include <algorithm>
#include <map>
#include <string>

namespace mv {

namespace {

// Each glyph is a list of strokes; a stroke is a row of points, two digits x y each, on a grid with the baseline at y = 2, small
// letters up to 7, capitals up to 9.
constexpr double baseline = 2, capital_height = 7, letter_gap = 1.6, space_width = 2.2;

const std::map<char, std::string>& glyphs() {
  static const std::map<char, std::string> table{{'0', "120308192938332212"},
                                                 {'.', "0203"},
                                                 {',', "1301"},
                                                 {':', "0304 0607"},
                                                 {';', "1301 1617"},
                                                 {'-', "0535"},
                                                 {'+', "0545 2327"},
                                                 {'/', "0239"},
                                                 {'(', "29171422"},
                                                 {')', "09272402"},
                                                 {'%', "0239 0818190908 2233322322"},
                                                 {'=', "0636 0434"},
                                                 {'<', "370533"},
                                                 {'>', "073503"},
                                                 {'1', "071912"},
                                                 {'2', "081929383702 0232"},
                                                 {'3', "093916263533221203"},
                                                 {'4', "22290434"},
                                                 {'5', "390906263533221203"},
                                                 {'6', "3829190803122233352606"},
                                                 {'7', "093912"},
                                                 {'8', "160708192938372616 16050312223335 3526"},
                                                 {'9', "351505080819293833221203"},
                                                 {'A', "022942 1434"},
                                                 {'B', "02092938372606 2635332202"},
                                                 {'C', "3829190803122233"},
                                                 {'D', "02091937341202"},
                                                 {'E', "39090232 0626"},
                                                 {'F', "390902 0626"},
                                                 {'G', "38291908031222333525"},
                                                 {'H', "0209 3239 0636"},
                                                 {'I', "0209"},
                                                 {'J', "29231203"},
                                                 {'K', "0209 3905 1632"},
                                                 {'L', "090232"},
                                                 {'M', "0209254942"},
                                                 {'N', "02093239"},
                                                 {'O', "120308192938332212"},
                                                 {'P', "02092938372606"},
                                                 {'Q', "120308192938332212 2432"},
                                                 {'R', "02092938372606 1632"},
                                                 {'S', "382919080716263533221203"},
                                                 {'T', "0949 2922"},
                                                 {'U', "090312223339"},
                                                 {'V', "092249"},
                                                 {'W', "0912273249"},
                                                 {'X', "0942 0249"},
                                                 {'Y', "092549 2522"},
                                                 {'Z', "09490242"},
                                                 {'a', "3732 3627170603122233"},
                                                 {'b', "0902 0617273633221203"},
                                                 {'c', "3627170603122233"},
                                                 {'d', "3932 3627170603122233"},
                                                 {'e', "05353627170603122233"},
                                                 {'f', "39291812 0727"},
                                                 {'g', "37312010 3627170603122233"},
                                                 {'h', "0902 0617273632"},
                                                 {'i', "0702 0809"},
                                                 {'j', "171100 1819"},
                                                 {'k', "0902 3704 1532"},
                                                 {'l', "0902"},
                                                 {'m', "0702 06172622 26374642"},
                                                 {'n', "0702 0617273632"},
                                                 {'o', "120306172736332212"},
                                                 {'p', "0700 0617273633221203"},
                                                 {'q', "3730 3627170603122233"},
                                                 {'r', "0702 061727"},
                                                 {'s', "36271706153433221203"},
                                                 {'t', "19132232 0737"},
                                                 {'u', "0703122233 3732"},
                                                 {'v', "072247"},
                                                 {'w', "0712253247"},
                                                 {'x', "0732 0237"},
                                                 {'y', "0722 4710"},
                                                 {'z', "07370232"}};
  return table;
}

}  // namespace

std::vector<std::vector<Vec2>> text_strokes(std::string_view text, const Vec2& origin, double height) {
  const double scale = height / capital_height;
  std::vector<std::vector<Vec2>> strokes;
  double x = 0;
  for (char c : text) {
    const auto glyph = glyphs().find(c);
    if (glyph == glyphs().end()) {
      x += space_width;
      continue;
    }
    const std::string& code = glyph->second;
    double width = 0;
    std::vector<Vec2> stroke;
    const auto finish = [&] {
      if (!stroke.empty()) strokes.push_back(std::move(stroke));
      stroke.clear();
    };
    for (std::size_t i = 0; i < code.size();) {
      if (code[i] == ' ') {
        finish();
        ++i;
        continue;
      }
      const double px = code[i] - '0', py = code[i + 1] - '0';
      width = std::max(width, px);
      stroke.push_back(origin + scale * Vec2(x + px, py - baseline));
      i += 2;
    }
    finish();
    x += width + letter_gap;
  }
  return strokes;
}

double text_width(std::string_view text, double height) {
  double widest = 0;
  for (const auto& stroke : text_strokes(text, Vec2::Zero(), height))
    for (const Vec2& p : stroke) widest = std::max(widest, p.x());
  return widest;
}

}  // namespace mv
