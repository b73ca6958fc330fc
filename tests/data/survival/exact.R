# Exact log-rank tests: writes exact_output.csv, one person's time a row, and the p of its data set.
# Scores are martingale residuals of survival's model without groups; p is the share of all
# labellings, within strata, whose sum is as far from 0. coin agrees where it has the test: two
# groups, no strata, no ties. Run once, in this folder: Rscript exact.R
# Debian: r-base-core r-cran-survival r-cran-coin
suppressPackageStartupMessages({ library(survival); library(coin) })
sums <- function(scores, strata, b) {
  found <- 0
  for (layer in unique(strata)) {
    here <- which(strata == layer)
    each <- if (sum(b[here])) combn(length(here), sum(b[here]), function(k) sum(scores[here[k]])) else 0
    found <- as.vector(outer(found, each, "+"))
  }
  found
}
exact <- function(name, set) {
  model <- if (length(unique(set$stratum)) > 1) coxph(Surv(time, event) ~ strata(stratum), set, ties = "breslow")
           else coxph(Surv(time, event) ~ 1, set, ties = "breslow")
  scores <- residuals(model, "martingale"); b <- set$group == "b"
  p <- mean(abs(sums(scores, set$stratum, b)) >= abs(sum(scores[b])) - 1e-9)
  if (!anyDuplicated(set$time)) {
    set$g <- factor(set$group)
    other <- as.numeric(pvalue(logrank_test(Surv(time, event) ~ g, set, distribution = "exact")))
    stopifnot(abs(other - p) < 1e-9)
  }
  cbind(dataset = name, set[c("time", "event", "group", "stratum")], p = sprintf("%.13g", p))
}
set.seed(20150323)
made <- function(n, strata, most) data.frame(
  time = if (most) sample(most, n, TRUE) else round(rexp(n, 0.01), 3),
  event = as.integer(runif(n) < 0.7), group = rep(c("a", "b"), length.out = n), stratum = strata)
sets <- list(
  no_ties = made(12, 1, 0), ties = made(13, 1, 6), pairs = made(16, rep(1:8, each = 2), 0),
  pairs_with_ties = made(18, rep(1:9, each = 2), 4), unequal_strata = made(14, rep(1:3, c(4, 5, 5)), 5))
sets$pairs$time[1:2] <- 100   # a tie within a pair, so that coin is not asked for strata
write.csv(do.call(rbind, Map(exact, names(sets), sets)), "exact_output.csv", row.names = FALSE, quote = FALSE)
writeLines(c(R.version.string, paste("survival", packageVersion("survival")),
             paste("coin", packageVersion("coin"))), "exact_session.txt")
