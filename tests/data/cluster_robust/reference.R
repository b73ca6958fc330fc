# What R's clubSandwich says of the exposures of ../oracles: writes r_output.csv and r_session.txt.
# Run once, in this folder: Rscript reference.R
# Debian: r-base-core r-cran-clubsandwich r-cran-lme4
suppressPackageStartupMessages({
  library(clubSandwich)
  library(lme4)
})
options(warn = 1)

found <- list()
add <- function(dataset, values) {
  stopifnot(!is.null(names(values)), all(nzchar(names(values))))
  text <- ifelse(is.finite(values), sprintf("%.17g", values), "")
  found[[length(found) + 1]] <<- data.frame(
    dataset = dataset, quantity = names(values), value = text
  )
}
precise <- lmerControl(optimizer = "bobyqa", check.conv.singular = "ignore",
                       optCtrl = list(rhobeg = 0.2, rhoend = 1e-12, maxfun = 1e5))
exposures <- read.csv("../oracles/exposures.csv", colClasses = "character", na.strings = "")
for (name in unique(exposures$dataset)) {
  mine <- exposures[exposures$dataset == name & !is.na(exposures$score), ]
  mine$score <- as.numeric(mine$score)
  mine$condition <- factor(mine$condition)
  models <- list(condition = "condition")
  if (length(unique(mine$period)) > 1) {
    mine$period <- factor(mine$period)
    models[["condition + period"]] <- c("condition", "period")
  }
  for (label in names(models)) {
    factors <- models[[label]]
    fit <- lmer(as.formula(paste("score ~", paste(factors, collapse = " + "), "+ (1 | participant)")),
                mine, control = precise)
    each <- coef_test(fit, vcov = "CR2", cluster = mine$participant, test = "Satterthwaite")
    terms <- names(fixef(fit))
    for (k in seq_along(terms)) {
      values <- c(estimate = each$beta[k], standard_error = each$SE[k], df = each$df_Satt[k],
                  p = each$p_Satt[k])
      names(values) <- paste0(label, "; ", terms[k], " ", names(values))
      add(name, values)
    }
    columns <- attr(getME(fit, "X"), "assign")
    for (k in seq_along(factors)) {
      whole <- Wald_test(fit, constrain_zero(which(columns == k)), "CR2", test = "HTZ",
                         cluster = mine$participant)
      values <- c(f = whole$Fstat, df_error = whole$df_denom, p = whole$p_val)
      names(values) <- paste0(label, "; ", factors[k], ": ", names(values))
      add(name, values)
    }
  }
}
write.csv(do.call(rbind, found), "r_output.csv", row.names = FALSE, quote = FALSE)
writeLines(capture.output(print(sessionInfo(), locale = FALSE)), "r_session.txt")
