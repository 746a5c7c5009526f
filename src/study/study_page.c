/// One self-contained page of all studies of a run, for a browser, without anything from elsewhere.
#include "study/study_files.h"

#include "io/file.h"
#include "io/xml_tag.h"

#include <string.h>

static const char page_style[] =
    "body{font:16px/1.5 Helvetica,Arial,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;"
    "color:#111;background:#fff}\n"
    "h1,h2{line-height:1.2}section{border-top:2px solid #111;margin-top:2.5em}\n"
    "table{border-collapse:collapse;margin:1em 0;font-size:14px}caption{text-align:left;"
    "font-weight:bold;padding:.3em 0}\n"
    "th,td{border-bottom:1px solid #bbb;padding:.2em .7em;text-align:right}"
    "th:first-child,td:first-child,.list td:nth-child(2),.list th:nth-child(2){text-align:left}\n"
    "svg{max-width:100%;height:auto;display:block;margin:1em 0}code{background:#eee;"
    "padding:.1em .3em}\n"
    ".wide{overflow-x:auto}.fails{border-left:6px solid #111;padding-left:.6em;font-weight:bold}\n"
    ".why{color:#444;font-size:14px}\n";

static void put_element(FILE *out, const char *element, const char *text) {
  fprintf(out, "<%s>", element);
  lth_xml_put_text(out, text);
  fprintf(out, "</%s>\n", element);
}

static void put_heading(FILE *out, const char *name, const char *unit) {
  fputs("<th>", out);
  lth_xml_put_text(out, name);
  if (*unit) {
    fputs(" [", out);
    lth_xml_put_text(out, unit);
    fputs("]", out);
  }
  fputs("</th>", out);
}

static void put_table(FILE *out, const LthTable *t) {
  char text[LTH_SHOWN_MAX];
  fputs("<div class=\"wide\"><table>", out);
  put_element(out, "caption", t->caption);
  fputs("<tr>", out);
  if (t->row_title) put_heading(out, t->row_title, "");
  for (int c = 0; c < t->n_columns; c++) put_heading(out, t->column[c].name, t->column[c].unit);
  fputs("</tr>\n", out);
  for (int row = 0; row < t->n_rows; row++) {
    fputs("<tr>", out);
    if (t->row_title) {
      fputs("<td>", out);
      lth_xml_put_text(out, t->word[row] ? t->word[row] : "");
      fputs("</td>", out);
    }
    for (int c = 0; c < t->n_columns; c++)
      fprintf(out, "<td>%s</td>",
              lth_shown_number(lth_table_at(t, row, c), t->column[c].digits, text));
    fputs("</tr>\n", out);
  }
  fputs("</table></div>\n", out);
}

static void put_figure(FILE *out, const char *svg, const char *caption) {
  fputs("<figure>", out);
  fputs(svg, out);
  put_element(out, "figcaption", caption);
  fputs("</figure>\n", out);
}

static void put_check(FILE *out, const LthCheck *check) {
  char text[4 * LTH_SHOWN_MAX];
  bool holds = lth_check_holds(check);
  fprintf(out, "<p class=\"%s\">%s %s: ", holds ? "holds" : "fails",
          holds ? "&#10003;" : "&#10007;", lth_shown_verdict(holds));
  lth_xml_put_text(out, check->what);
  fputs(": ", out);
  lth_xml_put_text(out, lth_shown_check(check, text));
  fputs("<br><span class=\"why\">", out);
  lth_xml_put_text(out, check->reason);
  fputs("</span></p>\n", out);
}

static void put_item(FILE *out, const LthItem *item) {
  if (item->kind == LTH_ITEM_TEXT) put_element(out, "p", item->text);
  if (item->kind == LTH_ITEM_TABLE && item->table->is_curve)
    fprintf(out, "<p>%s: <code>%s.csv</code></p>\n", item->table->caption, item->table->name);
  else if (item->kind == LTH_ITEM_TABLE)
    put_table(out, item->table);
  if (item->kind == LTH_ITEM_CHECK) put_check(out, item->check);
  if (item->kind == LTH_ITEM_PICTURE) put_figure(out, item->picture->svg, item->picture->caption);
  if (item->kind != LTH_ITEM_PLOT) return;
  if (item->plot->svg)
    put_figure(out, item->plot->svg, item->plot->title);
  else
    fprintf(out,
            "<p>Not drawn: gnuplot is not there. The script is <code>%s.gp</code>, the numbers "
            "stand in the tables.</p>\n",
            item->plot->name);
}

static void put_study(FILE *out, const LthStudyRun *run) {
  fprintf(out, "<section id=\"%s\">", run->study->name);
  fprintf(out, "<h2>%s: ", run->study->name);
  lth_xml_put_text(out, run->study->title);
  fputs("</h2>\n<p><em>", out);
  lth_xml_put_text(out, run->study->question);
  fprintf(out, "</em></p>\n<p><code>lithe study %s%s</code>, %.1f s</p>\n", run->study->name,
          run->quick ? " --quick" : "", run->seconds);
  for (const LthItem *item = run->report.first; item; item = item->next) put_item(out, item);
  if (run->trouble) {
    fputs("<p class=\"fails\">&#10007; STOPPED: ", out);
    lth_xml_put_text(out, run->trouble);
    fputs("</p>\n", out);
  }
  fputs("</section>\n", out);
}

static void put_overview(FILE *out, const LthStudyRun *runs) {
  int n_studies = 0, n_all = 0, n_bad = 0, n_stopped = 0;
  for (const LthStudyRun *run = runs; run; run = run->next) {
    int n_failed;
    n_studies++;
    n_all += lth_study_checks(&run->report, &n_failed);
    n_bad += n_failed;
    n_stopped += run->trouble != NULL;
  }
  fprintf(out, "<p>%d of %d verdicts of %d studies hold", n_all - n_bad, n_all, n_studies);
  if (n_stopped > 0) fprintf(out, ", %d studies stopped", n_stopped);
  fputs(". A verdict is a computed number against a bound that stands with its reason in the "
        "study's source.</p>\n",
        out);
  fputs("<table class=\"list\"><tr><th>study</th><th>what</th><th>verdicts that hold</th><th>all "
        "hold</th>"
        "<th>seconds</th></tr>\n",
        out);
  for (const LthStudyRun *run = runs; run; run = run->next) {
    int n_failed, n = lth_study_checks(&run->report, &n_failed);
    fprintf(out, "<tr><td><a href=\"#%s\">%s</a></td><td>", run->study->name, run->study->name);
    lth_xml_put_text(out, run->study->title);
    fprintf(out, "</td><td>%d of %d</td><td>%s</td><td>%.1f</td></tr>\n", n - n_failed, n,
            run->trouble           ? "&#10007; stopped"
            : lth_study_holds(run) ? "&#10003; yes"
                                   : "&#10007; NO",
            run->seconds);
  }
  fputs("</table>\n", out);
}

LitheStatus lth_study_write_page(LitheCtx *ctx, const char *folder, const LthPageHead *head,
                                 const LthStudyRun *runs) {
  char *path;
  LthFileWriter writer;
  LITHE_TRY(lth_path_join(ctx, folder, "index.html", &path));
  LitheStatus status = lth_file_open(ctx, path, &writer);
  lth_free(ctx, path);
  LITHE_TRY(status);
  FILE *out = writer.stream;
  fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width\">\n<title>",
        out);
  lth_xml_put_text(out, head->title);
  fprintf(out, "</title>\n<style>%s</style></head><body>\n", page_style);
  put_element(out, "h1", head->title);
  fputs("<p><code>", out);
  lth_xml_put_text(out, head->command);
  fprintf(out, "</code>, Lithe %d.%d.%d, %.1f s</p>\n", LITHE_VERSION_MAJOR, LITHE_VERSION_MINOR,
          LITHE_VERSION_PATCH, head->seconds);
  put_overview(out, runs);
  for (const LthStudyRun *run = runs; run; run = run->next) put_study(out, run);
  fputs("</body></html>\n", out);
  return lth_file_commit(ctx, &writer);
}
