# Makes the primary tests of this report again, in base R, from tables/scores.csv, and prints what
# the report has (tables/tests.csv) beside what R finds; then the crossover analyses, comparisons by
# other tests, equivalence, correlations, agreement and Kruskal-Wallis tests, in base R too, the
# analyses of variance (package car) and the mixed models (package lmerTest). Nothing is taken from
# the report but who is compared with whom, and how.
#
#   Rscript reproduce.R
#
# Where the package coin is installed, its exact signed-rank test is made as well. What needs a
# package that is not there is named and left out. The script ends with status 1 if a number differs
# by more than a relative 1e-6 (of mixed models 1e-5: both search for the largest likelihood).

LARGEST_DIFFERENCE <- 1e-6
LARGEST_OF_A_SEARCH <- 1e-5
MOST_OF_ROUNDING <- 1e-3  # SD of people over that of residuals: the search stops so far from 0
MOST_FOR_INTERVAL <- 30   # pairs: the interval is found by trying every shift
MOST_FOR_WALSH <- 3000    # pairs: n (n + 1) / 2 averages are made

script <- sub("^--file=", "", grep("^--file=", commandArgs(FALSE), value = TRUE))
folder <- if (length(script)) dirname(script[1]) else "."

# Everything is read as text: a score called T is no TRUE, a participant called 007 no number. The
# apostrophe that keeps a spreadsheet from computing a text such as =a is taken off again.
read_table <- function(name) {
  found <- read.csv(file.path(folder, "tables", paste0(name, ".csv")), colClasses = "character",
                    na.strings = "", check.names = FALSE, encoding = "UTF-8", quote = "\"")
  plain <- function(text) sub("^'('*[=+@\t\r\n-])", "\\1", text)
  names(found) <- plain(names(found))
  found[] <- lapply(found, plain)
  found
}

# The names in a cell that is a line of CSV itself.
names_in <- function(cell) {
  if (is.na(cell)) return(character())
  scan(text = cell, what = "", sep = ",", quote = "\"", na.strings = character(), quiet = TRUE,
       encoding = "UTF-8")
}

# FUNCTIONS

rows <- list()
compare <- function(test, what, expected, found, about = paste(test$a, "minus", test$b),
                    size = 1e-9, largest = LARGEST_DIFFERENCE) {
  expected <- suppressWarnings(as.numeric(expected))
  if (is.na(expected)) return(invisible())   # the report has none
  difference <- if (is.na(found)) Inf else abs(found - expected) / max(abs(expected), size)
  rows[[length(rows) + 1]] <<- data.frame(
    comparison = about, score = test$outcome, number = what, report = signif(expected, 9),
    R = signif(found, 9), difference = signif(difference, 2), wrong = !(difference <= largest))
}

# The p that R finds of each member of a family whose p values are adjusted together.
in_families <- list()
in_family <- function(line, p, about = paste(line$a, "minus", line$b)) {
  if (!is.na(line$p_holm)) {
    in_families[[length(in_families) + 1]] <<- list(line = line, p = p, about = about)
  }
}

scores <- read_table("scores")
# ANALYSES primary

# The models. Names of factors and levels may be anything: they are f1, f2, ... and numbers here.
TIMES <- " \u00d7 "
MINUS <- " \u2212 "
read_if_there <- function(name) {
  if (file.exists(file.path(folder, "tables", paste0(name, ".csv")))) {
    found <- read_table(name)
    if ("not_tested" %in% names(found)) found <- found[is.na(found$not_tested), , drop = FALSE]
    if (nrow(found)) found
  }
}
not_here <- function(...) cat("Not made here:", ..., "\n")
models <- 0

# ANALYSES order models

# Comparisons by other tests, and correlations: each person's mean over exposures.
others <- 0
means_of <- function(outcome, people, condition) {
  here <- is.na(condition) | scores$condition %in% condition
  mine <- here & !is.na(scores[[outcome]])
  means <- tapply(as.numeric(scores[[outcome]][mine]), scores$participant[mine], mean)
  unname(means[people])
}
unbiased <- function(df) exp(lgamma(df / 2) - lgamma((df - 1) / 2) - log(df / 2) / 2)

# ANALYSES tests

# Holm's method over all p values of a family: of tests, comparisons and effects of ANOVAs.
adjusted_in <- function(name) {
  found <- read_if_there(name)
  if ("p_holm" %in% names(found)) found$family[!is.na(found$p_holm)]
}
sizes <- table(unlist(lapply(c("tests", "comparisons", "anova"), adjusted_in)))
for (family in names(sizes)) {
  members <- Filter(function(each) each$line$family == family, in_families)
  p_values <- vapply(members, function(each) each$p, 1)
  if (length(members) < sizes[[family]] || anyNA(p_values)) {
    not_here("the adjusted p values of", family, "(not every p of the family is made here)")
    next
  }
  adjusted <- p.adjust(p_values, "holm")
  for (k in seq_along(members)) {
    line <- members[[k]]$line
    compare(line, "p, Holm", line$p_holm, adjusted[k], members[[k]]$about)
  }
}

table <- do.call(rbind, rows)
if (is.null(table)) {
  cat("This report has no test.\n")
  quit(status = 0)
}
options(width = 140)
print(table[names(table) != "wrong"], row.names = FALSE)
wrong <- sum(table$wrong)
cat(sprintf(paste0("\n%d numbers of %d tests, %d other tests and %d models; largest relative difference %g; ",
                   "%d differ by more than %g (of mixed models %g).\n"),
            nrow(table), nrow(done), others, models, max(table$difference), wrong, LARGEST_DIFFERENCE,
            LARGEST_OF_A_SEARCH))
cat(R.version.string, "\n")
quit(status = if (wrong) 1 else 0)
