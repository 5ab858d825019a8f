// The page, style and script of the report: the files of evaluation/report/, embedded when the program is
// built.
#pragma once

namespace ld {

extern const char* const kReportPage;  // with {{nonce}}, {{style}}, {{script}}, {{data}} and {{pictures}}
extern const char* const kReportStyle;
extern const char* const kReportScript;

}  // namespace ld
